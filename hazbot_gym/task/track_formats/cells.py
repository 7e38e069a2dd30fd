"""Cells of a delimited text file, parsed by pandas, with line numbers in errors."""

from __future__ import annotations

import io
import itertools
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_formats.layout import Layout, cells_of, is_number

_LONGEST_S = 1e9  # from the first time stamp to the last


class Cells:
    """Some columns of a text file.

    Attributes:
        rows: (N,) index of each row among the rows of the file.
    """

    def __init__(self, layout: Layout, columns: Iterable[int]) -> None:
        """Parse columns; rows that are empty in all of them are left out.

        Raises:
            InvalidInput: a row has too many cells.
        """
        import pandas as pd

        stream = io.BytesIO(layout.data)
        stream.seek(layout.offset)
        is_exact = tuple(int(part) for part in pd.__version__.split(".")[:2]) >= (3, 1)
        exact = {} if is_exact else {"float_precision": "round_trip"}
        try:
            frame = pd.read_csv(
                stream,
                sep=layout.separator or r"\s+",
                header=None,
                decimal=layout.decimal,
                comment="#",
                encoding=layout.encoding,
                skipinitialspace=True,
                low_memory=False,
                **exact,
            )
        except ValueError as error:  # pandas.errors.ParserError is one
            fault = f"{layout.name}: a quote is not closed: {' '.join(str(error).split())}"
            raise InvalidInput(self._width_fault(layout) or fault) from None
        if frame.shape[1] != len(layout.row):
            number, _ = next(layout.lines())
            fault = f"line {number}: {frame.shape[1]} columns instead of {len(layout.row)}"
            raise InvalidInput(f"{layout.name}: {fault}")
        self._layout = layout
        frame = frame[sorted(set(columns))]
        is_row = frame.notna().any(axis=1).to_numpy()
        self._frame = frame if is_row.all() else frame[is_row]
        self.rows: Ints = np.flatnonzero(is_row)

    def keep(self, is_kept: npt.NDArray[np.bool_]) -> None:
        """Drop the other rows."""
        self._frame, self.rows = self._frame[is_kept], self.rows[is_kept]

    def place_of(self, row: int) -> str:
        """Return the location of a row in the file."""
        return f"line {self._line(row)[0]}"

    def numbers(self, column: int) -> Floats:
        """Return a column as numbers.

        Raises:
            InvalidInput: a cell is none.
        """
        values = self._frame[column]
        if values.dtype.kind in "iuf":
            numbers: Floats = values.to_numpy(dtype=np.float64)
            missing = np.flatnonzero(np.isnan(numbers))
            if not len(missing):
                return numbers
            raise self._fault(int(missing[0]), column)
        texts = self.texts(column)
        bad = (row for row, text in enumerate(texts) if not self._is_number(text))
        first = next(bad, None)
        if first is not None:
            raise self._fault(first, column)
        return np.array([float(text.replace(self._layout.decimal, ".")) for text in texts])

    def ids(self, column: int) -> Floats:
        """Return a column as numbers of people; words are counted in order of appearance."""
        if self._frame[column].dtype.kind in "iuf":
            return self.numbers(column)
        texts = self.texts(column)
        if any(not text or self._is_number(text) for text in texts):
            return self.numbers(column)
        _, first, codes = np.unique(texts, return_index=True, return_inverse=True)
        ranks: Floats = np.argsort(np.argsort(first)).astype(np.float64)
        return ranks[codes] + 1.0

    def times_s(self, column: int, second_s: float) -> Floats:
        """Return a column of time stamps in seconds since the first one.

        Args:
            column: of numbers, or of dates and times after ISO 8601.
            second_s: Unit of the numbers in seconds.

        Raises:
            InvalidInput: a cell is neither, or the span is longer than any recording.
        """
        values = self._frame[column]
        texts = [] if values.dtype.kind in "iuf" else self.texts(column)
        if not texts or all(self._is_number(text) for text in texts):
            with np.errstate(over="ignore", invalid="ignore"):
                numbers = self.numbers(column)
                seconds: Floats = np.asarray((numbers - numbers.min()) * second_s)
        else:
            seconds = self._since_first(column)
        is_far = ~(seconds <= _LONGEST_S)
        if is_far.any():
            place = f"{self._layout.name}: {self.place_of(int(np.argmax(is_far)))}"
            raise InvalidInput(
                f"{place}: time stamps span over {_LONGEST_S:g} s; name their unit, as in time_ms"
            )
        return seconds

    def _since_first(self, column: int) -> Floats:
        import pandas as pd

        stamps = pd.to_datetime(self._frame[column], format="ISO8601", utc=True, errors="coerce")
        is_bad = stamps.isna().to_numpy()
        if is_bad.any():
            raise self._fault(int(np.argmax(is_bad)), column)
        seconds: Floats = (stamps - stamps.min()).dt.total_seconds().to_numpy(dtype=np.float64)
        return seconds

    def texts(self, column: int) -> list[str]:
        """Return the cells of a column as text, stripped."""
        return ["" if cell != cell else str(cell).strip() for cell in self._frame[column]]

    def _is_number(self, text: str) -> bool:
        return is_number(text, self._layout.decimal)

    def _line(self, row: int) -> tuple[int, str]:
        """Return number and text of a row's line."""
        index = int(self.rows[row])
        return next(itertools.islice(self._layout.lines(), index, None), (0, ""))

    def _fault(self, row: int, column: int) -> InvalidInput:
        """Return the fault of a cell that is not a finite number."""
        number, line = self._line(row)
        cells = cells_of(line, self._layout.separator)
        place = f"{self._layout.name}: line {number}"
        if column >= len(cells):
            width = len(self._layout.row)
            return InvalidInput(f"{place}: {len(cells)} columns instead of {width}")
        if self._is_number(cells[column]):
            return InvalidInput(f"{place}: a cell is not a finite number")
        return InvalidInput(f"{place}: {cells[column][:40]!r} is not a number")

    @staticmethod
    def _width_fault(layout: Layout) -> str:
        width = len(layout.row)
        for number, line in layout.lines():
            count = len(cells_of(line, layout.separator))
            if count > width:
                return f"{layout.name}: line {number}: {count} columns instead of {width}"
        return ""
