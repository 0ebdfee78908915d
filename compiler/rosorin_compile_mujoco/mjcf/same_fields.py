"""Which fields of mjModel are compared, under which feature, and why the others are not.

Each field of MuJoCo 4.0.0's mjModel, mjOption, mjVisual and mjStatistic stands here once: in ``KINDS`` (an object's
own, by name), in ``REFERENCES`` (which other object it names), in ``CARED_FOR`` (what ``same`` compares in a way of its
own), in ``WHOLE`` (arrays of one piece), or in ``EXCUSED``, with the reason. A test holds the list against MuJoCo's.
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

CARED_FOR: Mapping[str, str] = {
    "body_parentid body_pos body_quat": "where a body is in the next one above it that both models have",
    "body_mass body_ipos body_iquat body_inertia": "the whole inertia in the frame of the body, however it is split",
    "body_mocapid": "whether a body is moved by motion capture",
    "tree_sleep_policy": "the policy of the tree that a body is in",
    "jnt_bodyid jnt_pos jnt_axis": "anchor and axis in the frame of the body; what a slide is anchored at is nothing",
    "jnt_range": "counted from where the joint stands at first",
    "jnt_qposadr": "the order of the joints",
    "dof_jntid": "which degrees of freedom belong to a joint",
    "qpos0 qpos_spring": "where springs rest, and where joints stand at first",
    "geom_bodyid geom_pos geom_quat geom_size": "a shape in the frame of its body; of a mesh as the file has it",
    "geom_group": "visuals may be in 1 or 2, what collides in 0 or 3",
    "geom_rgba geom_matid": "the colour that is seen, and a material that is more than a colour",
    "mesh_vert mesh_normal mesh_pos mesh_quat": "as the file has them: where MuJoCo puts the origin depends on inertia",
    "mesh_graph mesh_graphadr": "how many vertices the convex hull has",
    "site_bodyid site_pos site_quat": "where it is in the frame of the body that had it",
    "cam_bodyid cam_pos cam_quat": "the same",
    "light_bodyid light_pos light_dir": "the same",
    "wrap_type wrap_prm tendon_adr tendon_num": "the path of a tendon",
    "tendon_range tendon_lengthspring": "counted from the length at first, as the positions of its joints",
    "actuator_ctrlrange actuator_biasprm": "counted from where the joint stands at first",
    "actuator_lengthrange": "found by a simulation where nothing says it, which ends near the same numbers",
    "actuator_ctrladr": "the order of the controls",
    "sensor_adr": "the order of the sensors",
    "exclude_signature": "which bodies may touch which others, with masks, pairs and neighbours",
    "key_qpos key_qvel key_act key_ctrl key_mpos key_mquat key_plastic": "by joint, actuator and body",
    "plugin plugin_attr plugin_attradr": "by what names a plugin: which one, and its settings",
    "names name_bodyadr name_jntadr name_geomadr name_siteadr name_camadr name_lightadr name_flexadr name_meshadr"
    " name_skinadr name_hfieldadr name_texadr name_matadr name_pairadr name_eqadr name_tendonadr"
    " name_actuatoradr name_sensoradr name_numericadr name_textadr name_tupleadr name_keyadr": "what is matched by",
    "nuserdata njmax nconmax": "what <size> says",
}
"""Fields that are compared in a way of their own, and how."""

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

_ADDRESS = "an address or a count of what is compared"
_TREE = "follows from bodies and joints"
_GEOMS = "follows from geoms and meshes"
_MATRIX = "the sparsity of a matrix, which follows from the tree"
_ZERO = "calculated by MuJoCo at the first pose"
_SIZE = "a size, which follows from what there is"

EXCUSED: Mapping[str, str] = {
    "nq nv nu nactuator nout na nbody nbvh nbvhstatic nbvhdynamic noct njnt ntree nM nB nC nD ngeom nsite ncam nlight"
    " nflex nflexnode nflexvert nflexedge nflexelem nflexelemdata nflexstiffness nflexbending nefm0dof nefm0L nefmCvert"
    " nflexelemedge nflexshelldata nflextexcoord nJfe nmesh nmeshvert nmeshnormal nmeshtexcoord nmeshface nmeshgraph"
    " nmeshpoly nmeshpolyvert nmeshpolymap nskin nskinvert nskintexvert nskinface nskinbone nskinbonevert nhfield"
    " nhfielddata ntex ntexdata nmat npair nexclude neq ntendon nJten nwrap nsensor nnumeric nnumericdata ntext"
    " ntextdata ntuple ntupledata nkey nmocap nplugin npluginattr nuser_body nuser_jnt nuser_geom nuser_site nuser_cam"
    " nuser_tendon nuser_actuator nuser_sensor nnames npaths nplastic nnames_map nJmom ngravcomp nemax npolygonmax"
    " nmeshdegmax nsensordata npluginstate nhistory nbuffer": _SIZE,
    "narena": "memory, which changes no motion",
    "flg_gravcomp flg_surfacevel flg_adhesion": "says whether a field that is compared is zero everywhere",
    "buffer": "where all this stands in memory",
    "signature": "a number of the compilation",
    "body_rootid body_weldid body_jntnum body_jntadr body_dofnum body_dofadr body_treeid body_geomnum body_geomadr"
    " body_simple dof_bodyid dof_parentid dof_treeid dof_Madr dof_simplenum jnt_dofadr tree_bodyadr tree_bodynum"
    " tree_dofadr tree_dofnum": _TREE,
    "body_subtreemass body_invweight0 dof_invweight0 dof_M0 dof_length tendon_length0 tendon_invweight0"
    " actuator_acc0 actuator_length0 cam_poscom0 cam_pos0 cam_mat0 light_poscom0 light_pos0 light_dir0 flex_vert0"
    " flex_node0 flexedge_invweight0 flex_size efm0_dofid efm0_L_rownnz efm0_L_rowadr efm0_L_colind efm0_L"
    " efmC_perm": _ZERO,
    "body_margin body_contype body_conaffinity body_bvhadr body_bvhnum body_sameframe bvh_depth bvh_child bvh_nodeid"
    " bvh_aabb oct_depth oct_child oct_aabb oct_coeff geom_sameframe geom_aabb geom_rbound site_sameframe"
    " mesh_bvhadr mesh_bvhnum mesh_octadr mesh_octnum mesh_extrema mesh_polynum mesh_polyadr mesh_polynormal"
    " mesh_polyvertadr mesh_polyvertnum mesh_polyvert mesh_polymapadr mesh_polymapnum mesh_polymap flex_bvhadr"
    " flex_bvhnum flex_elemedge flex_elemlayer flex_shell flex_shellnum flex_rigid flexedge_rigid"
    " flex_centered": _GEOMS,
    "mesh_vertadr mesh_vertnum mesh_faceadr mesh_facenum mesh_normaladr mesh_normalnum mesh_texcoordadr"
    " mesh_texcoordnum skin_vertadr skin_vertnum skin_texcoordadr skin_faceadr skin_facenum skin_boneadr skin_bonenum"
    " skin_bonevertadr hfield_adr tex_adr numeric_adr text_adr tuple_adr actuator_outadr actuator_actadr"
    " actuator_historyadr sensor_historyadr jnt_plasticadr tendon_plasticadr flex_nodeadr flex_vertadr flex_edgeadr"
    " flex_elemadr flex_elemdataadr flex_stiffnessadr flex_elemedgeadr flex_bendingadr flex_plasticadr"
    " flex_shelldataadr flex_texcoordadr plugin_stateadr plugin_statenum name_excludeadr name_pluginadr"
    " names_map": _ADDRESS,
    "mesh_scale": "the vertices have it, and those are compared",
    "jnt_actuatorid tendon_actuatorid": "says which actuator has damping or armature, which is compared there",
    "tendon_treenum tendon_treeid": _TREE,
    "actuator_ctrlspec": "declares what a control is, which a servo in numbers leaves open; nothing is computed of it",
    "ten_J_rownnz ten_J_rowadr ten_J_colind flexedge_J_rownnz flexedge_J_rowadr flexedge_J_colind B_rownnz B_rowadr"
    " B_colind M_rownnz M_rowadr M_colind mapM2M D_rownnz D_rowadr D_diag D_colind mapM2D mapD2M": _MATRIX,
    "pair_signature": "the bodies of the geoms of a pair",
    "paths mesh_pathadr skin_pathadr hfield_pathadr tex_pathadr tex_contenttypeadr": "where files lie; what is in them"
    " is compared",
    "opt vis stat": "field by field: options, settings of the viewer, statistics that the source says",
}
"""Fields of mjModel that are not compared, several in a word, and why."""
