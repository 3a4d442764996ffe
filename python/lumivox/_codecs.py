"""Native decoders in a process of their own: a damaged JPEG 2000 slice may crash it, and costs a slice, not the notebook."""

from __future__ import annotations

import importlib.util
import sys

from lumivox import _native

# Only the native module: a decoder needs nothing else, and starts at once.
_PROGRAM = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("lumivox._native", sys.argv[1])
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
module.serve_codecs()
"""


def install() -> None:
    """Names this interpreter as the program that decodes, where it is one that can be started again."""
    spec = importlib.util.find_spec("lumivox._native")
    if sys.executable and spec is not None and spec.origin is not None:
        _native.set_codec_worker(sys.executable, ["-c", _PROGRAM, spec.origin])
