"""Speed against accuracy, for a scene of one's own: `torsio.trade`."""

from torsio.trading.answers import trade
from torsio.trading.found import Row, Trade

__all__ = ["Row", "Trade", "trade"]
