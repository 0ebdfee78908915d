"""Pictures of a robot without a browser: the camera, colours and light of the ``view`` page, by numpy alone."""
