"""What the program brings itself: the modules of records of its own packages, in the order in which they are asked.

Packages of others say theirs by entry points (``plugins``).
"""

SHIPPED = (
    "commands.records",
    "tools.importer.records",
    "tools.extract.records",
    "tools.parameters.records",
    "tools.package.records",
    "tools.verify.records",
    "tools.physics.records",
    "tools.simulate.records",
    "tools.collisions.records",
    "tools.view.records",
    "tools.picture.records",
    "tools.sweep.records",
    "tools.fleet.records",
)

# The sections of the language that stand in folders of their own: where the record of each is.
SECTIONS = (
    "sections.servos:SERVOS",
    "sections.control:CONTROL",
    "sections.controllers:CONTROLLERS",
    "sections.moveit:MOVEIT",
    "sections.disabled_contacts:DISABLED_CONTACTS",
)
