"""The version of the tool."""

__version__ = "0.3.0"

# The URL of the project's files in a browser, ending in "/"; empty until it is published (RELEASING.md). The links in
# SARIF and the URLs of the package, which setup.py writes, are derived from it.
HOME = ""
