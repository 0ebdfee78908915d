"""Write files: the artifacts of a robot as one set, files of a package, and single files."""
