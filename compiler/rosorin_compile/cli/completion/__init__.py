"""rosorin-compile completion: a shell asks what may stand at the cursor, and the parser and the project answer."""
