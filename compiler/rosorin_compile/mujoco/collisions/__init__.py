"""collisions: find the pairs of links that need no collision check, as MoveIt's setup assistant does."""
