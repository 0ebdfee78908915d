"""Simulate a robot in MuJoCo: at rest, in its poses, driving, and along the ranges of its joints."""
