"""Robots of balls: a format, a rule, a function, a command and a check for rosorin-compile."""
