"""View: the robot in a browser, followed as its files change, or as one page to send.

To be read in this order: ``showing`` (a robot as the data of the page, with the lines that say so), ``server`` (who
gets what), ``command`` (what the user asks for).
"""
