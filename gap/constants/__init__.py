"""Every number that was set by hand and decides an answer, with where it comes from.

``docs/gap_constants.md`` has the table, and says which numbers of the diagnosis are not here. Each module
has those of one subject; take them from here.
"""

# ruff: noqa: F403 - all that these modules have is meant to be taken from here

from gap.constants.compared import *
from gap.constants.constant import Constant as Constant
from gap.constants.expected import *
from gap.constants.kept import *
from gap.constants.new import *
from gap.constants.search import *
from gap.constants.sure import *
from gap.constants.vibration import *
