"""``python -m tilesnav_validator``."""

import sys

from tilesnav_validator.cli import main

if __name__ == "__main__":
    sys.exit(main())
