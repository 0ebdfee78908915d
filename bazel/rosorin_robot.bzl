"""rosorin_robot: a robot that rosorin-compile makes of its description.

What it is made of is declared, and nothing else is read: no folder of the user, no cache, no ROS installation, no
variable of the environment. The artifacts are the same to the byte wherever they are made, so a remote cache serves
everybody. docs/builds.md has an example.
"""

# No cache outside, and nothing that the machine or its user would say.
_ENVIRONMENT = {
    "LC_ALL": "C.UTF-8",
    "NO_COLOR": "1",
    "PYTHONDONTWRITEBYTECODE": "1",
    "PYTHONNOUSERSITE": "1",
    "ROSORIN_COMPILE_CACHE": "off",
    "ROSORIN_COMPILE_PROGRESS": "off",
}

def _package_folder(target, name):
    """Return the folder of a ROS package: the one of its package.xml."""
    for file in target.files.to_list():
        if file.basename == "package.xml":
            return file.dirname
    fail("packages: %s has no package.xml, which tells where the ROS package %s is" % (target.label, name))

def _rosorin_robot_impl(ctx):
    if ctx.attr.outs:
        outputs = [ctx.actions.declare_file(ctx.label.name + "/" + out) for out in ctx.attr.outs]
        folder = outputs[0].path[:-len(ctx.attr.outs[0]) - 1]
    else:
        outputs = [ctx.actions.declare_directory(ctx.label.name)]
        folder = outputs[0].path

    words = ctx.actions.args()
    words.add_all(["all", ctx.file.description.path, "-o", folder, "-q"])
    for output in ctx.attr.only:
        words.add_all(["--only", output])
    for name, value in sorted(ctx.attr.arguments.items()):
        words.add_all(["-a", "%s=%s" % (name, value)])
    for file in ctx.files.argument_files:
        words.add_all(["--args", file.path])
    for target, name in ctx.attr.packages.items():
        words.add_all(["--package", "%s=%s" % (name, _package_folder(target, name))])
    if ctx.attr.trust:
        words.add("--trust")

    inputs = [ctx.file.description] + ctx.files.srcs + ctx.files.argument_files + ctx.files.packages
    ctx.actions.run(
        executable = ctx.executable.tool,
        arguments = [words],
        inputs = depset(inputs),
        outputs = outputs,
        env = _ENVIRONMENT,
        mnemonic = "RosorinRobot",
        progress_message = "Compiling robot %s" % ctx.label,
    )
    return [
        DefaultInfo(files = depset(outputs), runfiles = ctx.runfiles(files = outputs)),
        OutputGroupInfo(**{out: depset([file]) for out, file in zip(ctx.attr.outs, outputs)}),
    ]

rosorin_robot = rule(
    implementation = _rosorin_robot_impl,
    doc = "Compiles a description. Without `outs` the target is the folder of all artifacts.",
    attrs = {
        "description": attr.label(
            doc = "The first file of the description: robot.yaml.",
            allow_single_file = True,
            mandatory = True,
        ),
        "srcs": attr.label_list(
            doc = "All other files that it is made of: includes, tables, templates, meshes.",
            allow_files = True,
        ),
        "outs": attr.string_list(
            doc = "The artifacts, as the description calls them: each is an output group, too, of that name.",
        ),
        "only": attr.string_list(
            doc = "Names under outputs: of the description; without them all are made.",
        ),
        "arguments": attr.string_dict(
            doc = "Arguments of the description.",
        ),
        "argument_files": attr.label_list(
            doc = "YAML files of arguments, such as a calibration.",
            allow_files = [".yaml", ".yml", ".json"],
        ),
        "packages": attr.label_keyed_string_dict(
            doc = "ROS packages that the description names: their files, among them package.xml, to the name.",
            allow_files = True,
        ),
        "trust": attr.bool(
            doc = "Say nothing of what an included xacro can run.",
        ),
        "tool": attr.label(
            doc = "rosorin-compile, as a target: the version of the tool is an input like any other.",
            executable = True,
            cfg = "exec",
            mandatory = True,
        ),
    },
)
