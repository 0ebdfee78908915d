"""Draw pictures of a robot without a browser, with the camera, colours and light of the ``view`` page."""
