"""Commands: the core's own, each a module or folder: ``options`` says what one takes, ``run`` returns the exit code.

Small ones are one module (``all``, ``check``, ``diff``, ``frames``, ...). In a folder, ``command`` is the command and
the rest what it works with: ``completion``, ``explain``; ``transforms`` has two. What several share: ``parser`` and
``options`` (the command line), ``given`` (arguments), ``robots`` (those asked for), ``compiling`` and ``understanding``
them, ``usage`` (how a run ends), ``sides`` and ``foreign`` (files in other formats).
"""
