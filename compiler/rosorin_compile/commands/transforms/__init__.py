"""Transforms and servo pulses, as commands answer them."""
