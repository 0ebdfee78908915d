"""Tools: the commands, each a module or folder: ``options`` says what one takes, ``run`` returns the exit code.

Small ones are one module (``all``, ``check``, ``diff``, ``frames``, ...). In a folder, ``command`` is the command and
the rest what it works with: ``explain``, ``extract``, ``importer``, ``package``, ``transforms``, ``verify``.
``shared`` and ``parser`` are what all of them share, ``sides`` and ``foreign`` what several ask of files in other
formats.
"""
