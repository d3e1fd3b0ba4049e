"""Speed against accuracy, for a scene of one's own: `torsio.trade`."""

from torsio.trading.answers import Row, Trade, trade

__all__ = ["Row", "Trade", "trade"]
