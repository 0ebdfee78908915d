"""The section ``disabled_contacts``: pairs of links that touch by construction and are not to collide in simulation."""

from rosorin_compile.model.sections import OwnSection

DISABLED_CONTACTS: OwnSection[tuple[tuple[str, str], ...]] = OwnSection.in_folder(
    __name__, __path__[0], (), after="moveit", lowers="lowering:pairs_of", compares="comparison:compare"
)
