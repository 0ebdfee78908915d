"""The version of this package."""

__version__ = "0.4.0"

# Base URL of the files of the project, ending in "/"; empty until the project is published (RELEASING.md). Links in
# SARIF reports and URLs in the metadata of the package (setup.py) are derived from it.
HOME = ""
