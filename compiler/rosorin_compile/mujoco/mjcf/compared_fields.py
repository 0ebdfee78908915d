"""Which fields of mjModel are compared, and under which feature.

``KINDS`` has an object's own, by name, ``REFERENCES`` what names another object, ``WHOLE`` arrays that are one piece.
What ``compared`` compares in a way of its own, and what need not be compared, stands beside the test that holds all of
them against the fields that MuJoCo 4.0.0 publishes (tests/in_mujoco/mjcf/other_fields.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Kind(NamedTuple):
    """A kind of object: its mjOBJ, the prefix and the count of its arrays, and its plain fields by feature."""

    obj: str
    prefix: str
    total: str
    fields: Mapping[str, str]


KINDS: Mapping[str, Kind] = {
    "body": Kind("BODY", "body", "nbody", {"gravity compensation": "gravcomp", "user data": "user"}),
    "joint": Kind(
        "JOINT",
        "jnt",
        "njnt",
        {
            "types of joints": "type",
            "ranges of joints": "limited",
            "forces of joints": "actfrclimited actfrcrange",
            "springs": "stiffness stiffnesspoly springyield",
            "tuning of joints": "solref solimp margin",
            "gravity compensation": "actgravcomp",
            "groups": "group",
            "user data": "user",
        },
    ),
    "mesh": Kind("MESH", "mesh", "nmesh", {"shapes": "face facenormal facetexcoord texcoord"}),
    "height field": Kind("HFIELD", "hfield", "nhfield", {"shapes": "size nrow ncol data"}),
    "texture": Kind("TEXTURE", "tex", "ntex", {"textures": "type colorspace height width nchannel data"}),
    "material": Kind(
        "MATERIAL",
        "mat",
        "nmat",
        {
            "colours": "rgba",
            "shine": "texuniform texrepeat emission specular shininess reflectance metallic roughness",
        },
    ),
    "geom": Kind(
        "GEOM",
        "geom",
        "ngeom",
        {
            "shapes": "type",
            "masks": "contype conaffinity",
            "contact": "condim priority solmix solref solimp friction margin gap surfacevel adhesion",
            "drag": "fluid",
            "looks": "castshadow",
            "user data": "user",
        },
    ),
    "site": Kind("SITE", "site", "nsite", {"looks of sites": "type size rgba group", "user data": "user"}),
    "camera": Kind(
        "CAMERA",
        "cam",
        "ncam",
        {"cameras": "mode projection fovy ipd resolution output sensorsize intrinsic", "user data": "user"},
    ),
    "light": Kind(
        "LIGHT",
        "light",
        "nlight",
        {
            "lights": "mode type castshadow bulbradius intensity range active attenuation cutoff softness exponent"
            " ambient diffuse specular"
        },
    ),
    "pair": Kind(
        "PAIR", "pair", "npair", {"contact pairs": "dim solref solreffriction solimp margin gap adhesion friction"}
    ),
    "flex": Kind("FLEX", "flex", "nflex", {}),
    "skin": Kind("SKIN", "skin", "nskin", {}),
    "tendon": Kind(
        "TENDON",
        "tendon",
        "ntendon",
        {
            "tendons": "type limited actfrclimited width solref_lim solimp_lim solref_fri solimp_fri actfrcrange margin"
            " stiffness stiffnesspoly damping dampingpoly armature frictionloss springyield rgba group",
            "user data": "user",
        },
    ),
    "equality": Kind(
        "EQUALITY", "eq", "neq", {"equalities": "type objtype active0 data", "tuning of equalities": "solref solimp"}
    ),
    "actuator": Kind(
        "ACTUATOR",
        "actuator",
        "nactuator",
        {
            "actuators": "trntype dyntype gaintype biastype ctrlnum outnum actnum cranklength dynprm gainprm"
            " actlimited actrange actearly history delay damping dampingpoly armature forcelimited forcerange"
            " ctrllimited gear",
            "groups": "group",
            "user data": "user",
        },
    ),
    "sensor": Kind(
        "SENSOR",
        "sensor",
        "nsensor",
        {
            "sensors": "type datatype needstage objtype reftype intprm dim cutoff noise history delay interval",
            "user data": "user",
        },
    ),
    "number": Kind("NUMERIC", "numeric", "nnumeric", {"numbers and texts": "size data"}),
    "text": Kind("TEXT", "text", "ntext", {"numbers and texts": "size data"}),
    "tuple": Kind("TUPLE", "tuple", "ntuple", {"numbers and texts": "size objtype objprm"}),
    "key": Kind("KEY", "key", "nkey", {"keys": "time"}),
}
"""The kinds of objects, in the order in which they are matched: what names another one comes after it."""

OF_DOFS = {
    "damping": "damping dampingpoly",
    "armature": "armature",
    "friction loss": "frictionloss",
    "tuning of joints": "solref solimp",
}
"""What stands at the degrees of freedom of a joint, by feature: arrays that begin with dof."""

# Where the values of an object stand that has several: its first one and how many, or the size of one.
SLICES: Mapping[str, tuple[str, str]] = {
    "mesh_face": ("mesh_faceadr", "mesh_facenum"),
    "mesh_facenormal": ("mesh_faceadr", "mesh_facenum"),
    "mesh_facetexcoord": ("mesh_faceadr", "mesh_facenum"),
    "mesh_texcoord": ("mesh_texcoordadr", "mesh_texcoordnum"),
    "hfield_data": ("hfield_adr", "hfield_nrow hfield_ncol"),
    "tex_data": ("tex_adr", "tex_height tex_width tex_nchannel"),
    "numeric_data": ("numeric_adr", "numeric_size"),
    "text_data": ("text_adr", "text_size"),
    "tuple_objtype": ("tuple_adr", "tuple_size"),
    "tuple_objid": ("tuple_adr", "tuple_size"),
    "tuple_objprm": ("tuple_adr", "tuple_size"),
    "actuator_ctrllimited": ("actuator_ctrladr", "actuator_ctrlnum"),
    "actuator_ctrlrange": ("actuator_ctrladr", "actuator_ctrlnum"),
    "actuator_gear": ("actuator_outadr", "actuator_outnum"),
    "actuator_lengthrange": ("actuator_outadr", "actuator_outnum"),
    "wrap_type": ("tendon_adr", "tendon_num"),
    "wrap_objid": ("tendon_adr", "tendon_num"),
    "wrap_prm": ("tendon_adr", "tendon_num"),
}

# A field that means nothing unless another one is set.
GATES = {
    **dict.fromkeys(("jnt_solref", "jnt_solimp", "jnt_margin"), "jnt_limited"),
    "jnt_range": "jnt_limited",
    "jnt_actfrcrange": "jnt_actfrclimited",
    "tendon_range": "tendon_limited",
    "tendon_actfrcrange": "tendon_actfrclimited",
    "actuator_ctrlrange": "actuator_ctrllimited",
    "actuator_forcerange": "actuator_forcelimited",
    "actuator_actrange": "actuator_actlimited",
}

REFERENCES: Mapping[str, tuple[str, str]] = {
    "geom_dataid": ("geom_type", "shapes"),
    "site_matid": ("material", "looks of sites"),
    "site_dataid": ("mesh", "looks of sites"),
    "tendon_matid": ("material", "tendons"),
    "mat_texid": ("texture", "textures"),
    "cam_targetbodyid": ("body", "cameras"),
    "light_targetbodyid": ("body", "lights"),
    "light_texid": ("texture", "lights"),
    "pair_geom1": ("geom", "contact pairs"),
    "pair_geom2": ("geom", "contact pairs"),
    "eq_obj1id": ("eq_type", "equalities"),
    "eq_obj2id": ("eq_type", "equalities"),
    "actuator_trnid": ("actuator_trntype", "actuators"),
    "sensor_objid": ("sensor_objtype", "sensors"),
    "sensor_refid": ("sensor_reftype", "sensors"),
    "tuple_objid": ("tuple_objtype", "numbers and texts"),
    "wrap_objid": ("wrap_type", "tendons"),
    "body_plugin": ("plugin", "plugins"),
    "geom_plugin": ("plugin", "plugins"),
    "actuator_plugin": ("plugin", "plugins"),
    "sensor_plugin": ("plugin", "plugins"),
}
"""Fields that name another object: of which kind, or which field says of which kind; and the feature."""

WHOLE: Mapping[str, str] = {
    "flexible bodies": "flex_contype flex_conaffinity flex_condim flex_priority flex_solmix flex_solref flex_solimp"
    " flex_friction flex_margin flex_gap flex_selfcollide flex_activelayers flex_passive flex_dim flex_group"
    " flex_interp flex_cellnum flex_nodenum flex_vertnum flex_edgenum flex_elemnum flex_plasticmode flex_vertcell"
    " flex_edge flex_edgeflap flex_elem flex_elemtexcoord flex_vert flex_node flexedge_length0 flex_radius"
    " flex_stiffness flex_bending flex_damping flex_yield flex_edgestiffness flex_edgedamping flex_edgeequality"
    " flex_flatskin flex_rgba flex_texcoord flex_nodebodyid flex_vertbodyid flex_matid",
    "skins": "skin_group skin_rgba skin_inflate skin_vert skin_texcoord skin_face skin_bonevertnum skin_bonebindpos"
    " skin_bonebindquat skin_bonevertid skin_bonevertweight skin_bonebodyid skin_matid",
}
"""Arrays that are compared as one piece, by feature: few robots have them."""

BODY_IDS = ("flex_nodebodyid", "flex_vertbodyid", "skin_bonebodyid")
MATERIAL_IDS = ("flex_matid", "skin_matid")
