"""Fields of mjModel that are compared in a way of their own, or need not be compared, each with the reason.

Sizes, addresses and counts need no entry: MuJoCo publishes which fields those are (``follows``).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

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


EXCUSED: Mapping[str, tuple[str, ...]] = {
    "says whether a field that is compared is zero everywhere": ("flg_gravcomp flg_surfacevel flg_adhesion",),
    "where all this stands in memory": ("buffer",),
    "a number of the compilation": ("signature",),
    "follows from bodies and joints": (
        "body_rootid body_weldid body_treeid body_simple dof_bodyid dof_parentid dof_treeid tendon_treeid",
    ),
    "calculated by MuJoCo at the first pose": (
        "body_subtreemass body_invweight0 dof_invweight0 dof_M0 dof_length tendon_length0 tendon_invweight0",
        "actuator_acc0 actuator_length0 cam_poscom0 cam_pos0 cam_mat0 light_poscom0 light_pos0 light_dir0",
        "flex_vert0 flex_node0 flexedge_invweight0 flex_size efm0_dofid efm0_L_rownnz efm0_L_colind efm0_L",
        "efmC_perm",
    ),
    "follows from geoms and meshes": (
        "body_margin body_contype body_conaffinity body_sameframe bvh_depth bvh_child bvh_nodeid bvh_aabb",
        "oct_depth oct_child oct_aabb oct_coeff geom_sameframe geom_aabb geom_rbound site_sameframe",
        "mesh_extrema mesh_polynormal mesh_polyvert mesh_polymap flex_elemedge flex_elemlayer flex_shell",
        "flex_rigid flexedge_rigid flex_centered",
    ),
    "an address or a count of what is compared": ("names_map",),
    "the vertices have it, and those are compared": ("mesh_scale",),
    "says which actuator has damping or armature, which is compared there": ("jnt_actuatorid tendon_actuatorid",),
    "declares what a control is, which a servo in numbers leaves open; nothing is computed of it": (
        "actuator_ctrlspec",
    ),
    "the sparsity of a matrix, which follows from the tree": (
        "ten_J_rownnz ten_J_colind flexedge_J_rownnz flexedge_J_colind B_rownnz B_colind M_rownnz M_colind",
        "mapM2M D_rownnz D_diag D_colind mapM2D mapD2M",
    ),
    "the bodies of the geoms of a pair": ("pair_signature",),
    "where files lie; what is in them is compared": ("paths",),
    "field by field: options, settings of the viewer, statistics that the source says": ("opt vis stat",),
}
"""Other fields of mjModel that are not compared, by the reason, several in a text."""


def follows(field: Any) -> bool:
    """Say whether a field that MuJoCo publishes is a size, or an address or a count of what is compared."""
    is_size = getattr(field, "array_extent", None) is None and field.name.startswith("n")
    return is_size or field.name.endswith(("adr", "num"))
