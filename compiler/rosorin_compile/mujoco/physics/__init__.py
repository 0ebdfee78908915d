"""check physics: find impossible masses, overlapping parts and unstable robots with MuJoCo and the meshes."""
