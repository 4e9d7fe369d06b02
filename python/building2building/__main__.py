"""``python -m building2building`` is the command ``b2b``."""

import sys

from . import _core

_core.run_command(_core.__file__, *sys.argv[1:])
