"""``python -m skyshed`` is the program."""

import sys

from skyshed._program import main

sys.exit(main())
