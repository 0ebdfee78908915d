"""Words of SDF that its reader and its writer share."""

from __future__ import annotations

# What SDF 1.9 knows in a model, a link and a joint, beside what a description says in words. Gazebo takes each as it
# stands out of a <gazebo> of a URDF (gazebosim/sdformat@sdf12:src/parser_urdf.cc).
OF_MODEL = ("plugin", "static", "self_collide", "allow_auto_disable", "enable_wind")
OF_LINK = (
    *("sensor", "gravity", "enable_wind", "self_collide", "kinematic", "must_be_base_link", "velocity_decay"),
    *("light", "particle_emitter", "projector", "audio_source", "audio_sink", "battery"),
)
OF_JOINT = ("sensor", "physics")
