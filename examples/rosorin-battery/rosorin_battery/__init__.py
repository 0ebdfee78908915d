"""Batteries: a section for rosorin-compile that puts their mass where they are."""
