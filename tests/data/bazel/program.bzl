"""A script as a program, without the rules of other repositories, which a machine without network has not."""

def _impl(ctx):
    out = ctx.actions.declare_file(ctx.label.name)
    ctx.actions.symlink(output = out, target_file = ctx.file.script, is_executable = True)
    return [DefaultInfo(executable = out)]

program = rule(
    implementation = _impl,
    executable = True,
    attrs = {"script": attr.label(allow_single_file = True)},
)
