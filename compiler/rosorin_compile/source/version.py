"""The version of the tool."""

__version__ = "0.3.0"

# Where a browser finds the files of the project, ending in "/"; empty until there is an address (RELEASING.md). SARIF's
# links and the urls of the package, which setup.py writes, are derived from it.
HOME = ""
