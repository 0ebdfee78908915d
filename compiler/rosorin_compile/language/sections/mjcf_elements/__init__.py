"""The section ``mjcf_elements``: sections of MJCF that are kept as they are. Links have such elements, too."""

from rosorin_compile.model.sections import OwnSection

MJCF_ELEMENTS: OwnSection[tuple[str, ...]] = OwnSection.in_folder(
    __name__, __path__[0], (), after="contact_pairs", lowers="lowering:mjcf_elements_of", rules="rules"
)
