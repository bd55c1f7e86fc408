"""What a campaign's runs have measured, as kinds of experiment are asked about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from stiffcal.campaign.loading import Campaign

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.model.summary import EffectAt

T = TypeVar("T")


@dataclass(frozen=True)
class MeasuredRuns:
    """A campaign and the tables that were made of its runs' logs."""

    campaign: Campaign
    tables: Mapping[str, pa.Table]
    """Those that the kinds of experiment make, by name, as far as there are any."""
    n_states: int
    """Load states that other runs gave, n of them; 0 where the campaign holds none."""
    store: str = "store"
    """How messages name the store."""
    missing: tuple[EffectAt, ...] = ()
    """Effects that the diagnosis of the present fit names; empty where there is none, or nothing asks for them."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The names of the logged joints, L of them."""
        return self.campaign.chain.joint_names

    def read(self, name: str, from_table: Callable[[pa.Table], T]) -> T | None:
        """Return the content of a table, None where there is no such table.

        Parameters
        ----------
        name : of the table in the store.
        from_table : turns it into arrays.

        Raises
        ------
        DamagedError : the table holds something else.
        """
        table = self.tables.get(name)
        if table is None:
            return None
        try:
            return from_table(table)
        except (ValueError, TypeError, KeyError, IndexError, AttributeError, OverflowError, RecursionError) as error:
            from stiffcal.store.origin import damaged

            raise damaged(self.store, name, (str(error).splitlines() or [""])[0]) from error
