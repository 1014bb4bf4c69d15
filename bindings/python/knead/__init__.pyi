# Made by bindings/python/tests/make_stubs.py.
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableSequence, Sequence
from os import PathLike
from typing import Any, ClassVar, Literal, Protocol, SupportsIndex, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = Sequence[float] | NDArray[Any]
Points3 = Sequence[Vector] | NDArray[Any]
Faces = NDArray[np.integer[Any]] | Sequence[Sequence[int] | NDArray[np.integer[Any]]]
Path = str | PathLike[str]
Precision = Literal["float32", "float64", "float", "double"]
Integrator = Literal["tsit5", "rk4"]
Progress = Callable[[float], bool | None]
Mirror = str | dict[str, Any] | list[dict[str, Any]]
_Mesh = TypeVar("_Mesh")

class HasVertices(Protocol):
    @property
    def vertices(self) -> Any: ...

class HasPoints(Protocol):
    @property
    def points(self) -> Any: ...

Points_ = ArrayLike | HasVertices | HasPoints

__version__: str

class InvalidInput(ValueError): ...
class FileError(OSError): ...
class AccuracyError(RuntimeError): ...
class Unavailable(RuntimeError): ...

class Stroke:
    tool: ClassVar[str]
    name: str
    off: bool
    strength: float
    duration: float
    mirror: Mirror
    new_entry: bool | None
    def to_dict(self) -> dict[str, Any]: ...
    @classmethod
    def describe(cls) -> list[dict[str, Any]]: ...
    def replace(self: _S, **keys: Any) -> _S: ...
    def __hash__(self) -> int: ...

_S = TypeVar("_S", bound=Stroke)

def stroke(keys: Mapping[str, Any] | Stroke) -> Stroke: ...

class Implicit(Stroke):
    path: Points3
    inner: float | None
    outer: float | None
    bump: float | None
    core: float | None
    region: Literal['ball', 'capsule'] | None
    half_axis: Vector | None
    gauge: float | None
    time: Literal['swept', 'blended'] | None
    taper: float | None
    falloff: int | Literal['wide'] | None
    def __init__(
        self,
        *,
        path: Points3,
        inner: float | None = None,
        outer: float | None = None,
        bump: float | None = None,
        core: float | None = None,
        region: Literal['ball', 'capsule'] | None = None,
        half_axis: Vector | None = None,
        gauge: float | None = None,
        time: Literal['swept', 'blended'] | None = None,
        taper: float | None = None,
        falloff: int | Literal['wide'] | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Paint(Stroke):
    outer: float | None
    bump: float | None
    depth: float | None
    pinch: float | None
    samples: Sequence[Mapping[str, Vector]] | None
    path: Points3 | None
    falloff: int | Literal['wide'] | None
    def __init__(
        self,
        *,
        outer: float | None = None,
        bump: float | None = None,
        depth: float | None = None,
        pinch: float | None = None,
        samples: Sequence[Mapping[str, Vector]] | None = None,
        path: Points3 | None = None,
        falloff: int | Literal['wide'] | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Points(Stroke):
    points: Points3 | None
    curves: Sequence[Points3] | None
    outer: float
    displacements: Points3
    exponent: int | None
    inner: float | None
    center: Literal['parts', 'barycentre'] | None
    falloff: int | None
    def __init__(
        self,
        *,
        outer: float,
        displacements: Points3,
        points: Points3 | None = None,
        curves: Sequence[Points3] | None = None,
        exponent: int | None = None,
        inner: float | None = None,
        center: Literal['parts', 'barycentre'] | None = None,
        falloff: int | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Handles(Stroke):
    full: Points3 | None
    full_vertices: Sequence[int] | None
    zero: Points3 | None
    zero_vertices: Sequence[int] | None
    motion: Mapping[str, Any]
    exponent: int | None
    falloff: int | None
    def __init__(
        self,
        *,
        motion: Mapping[str, Any],
        full: Points3 | None = None,
        full_vertices: Sequence[int] | None = None,
        zero: Points3 | None = None,
        zero_vertices: Sequence[int] | None = None,
        exponent: int | None = None,
        falloff: int | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Stamp(Stroke):
    mesh: str
    path: Points3
    pose: Points3 | None
    outer: float | None
    step: float | None
    contact: Literal['auto', 'stick', 'slip'] | None
    exponent: int | None
    falloff: int | None
    def __init__(
        self,
        *,
        mesh: str,
        path: Points3,
        pose: Points3 | None = None,
        outer: float | None = None,
        step: float | None = None,
        contact: Literal['auto', 'stick', 'slip'] | None = None,
        exponent: int | None = None,
        falloff: int | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Rotate(Stroke):
    center: Vector
    axis: Vector
    angle_deg: float
    inner: float
    outer: float
    gauge: float | None
    falloff: int | None
    def __init__(
        self,
        *,
        center: Vector,
        axis: Vector,
        angle_deg: float,
        inner: float,
        outer: float,
        gauge: float | None = None,
        falloff: int | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Stretch(Stroke):
    center: Vector
    axis: Vector
    factor: float
    inner: float
    outer: float
    falloff: int | None
    def __init__(
        self,
        *,
        center: Vector,
        axis: Vector,
        factor: float,
        inner: float,
        outer: float,
        falloff: int | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Twist(Stroke):
    center: Vector
    axis: Vector
    rate_deg: float | None
    angle_deg: float | None
    inner: float
    outer: float
    normal: Vector | None
    gauge: float | None
    radius: float | Literal['auto'] | None
    falloff: int | None
    def __init__(
        self,
        *,
        center: Vector,
        axis: Vector,
        inner: float,
        outer: float,
        rate_deg: float | None = None,
        angle_deg: float | None = None,
        normal: Vector | None = None,
        gauge: float | None = None,
        radius: float | Literal['auto'] | None = None,
        falloff: int | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Bend(Stroke):
    center: Vector
    axis: Vector
    normal: Vector
    angle_deg: float
    width: float | None
    center_fraction: float | None
    inner: float | None
    outer: float | None
    gauge: float | None
    radius: float | Literal['auto'] | None
    falloff: int | None
    def __init__(
        self,
        *,
        center: Vector,
        axis: Vector,
        normal: Vector,
        angle_deg: float,
        width: float | None = None,
        center_fraction: float | None = None,
        inner: float | None = None,
        outer: float | None = None,
        gauge: float | None = None,
        radius: float | Literal['auto'] | None = None,
        falloff: int | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Curve(Stroke):
    from_: Points3 | None
    to: Points3 | None
    twist_deg: float | None
    longer_by: float | None
    thicker_by: float | None
    thickness: float | None
    thickness_before: float | None
    taper: bool | None
    angle_deg: float | None
    around: float | None
    axis: Vector | None
    length: Literal['keep', 'fit'] | None
    fixed: Literal['middle', 'start', 'end'] | None
    keep: Literal['volume', 'thickness', 'length'] | None
    radius: float | Literal['auto'] | None
    def __init__(
        self,
        *,
        from_: Points3 | None = None,
        to: Points3 | None = None,
        twist_deg: float | None = None,
        longer_by: float | None = None,
        thicker_by: float | None = None,
        thickness: float | None = None,
        thickness_before: float | None = None,
        taper: bool | None = None,
        angle_deg: float | None = None,
        around: float | None = None,
        axis: Vector | None = None,
        length: Literal['keep', 'fit'] | None = None,
        fixed: Literal['middle', 'start', 'end'] | None = None,
        keep: Literal['volume', 'thickness', 'length'] | None = None,
        radius: float | Literal['auto'] | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Lattice(Stroke):
    file: str | None
    origin: Vector | None
    axes: Points3 | None
    lengths: Vector | None
    counts: Sequence[int] | None
    displacements: Points3 | None
    mode: Literal['volume', 'rigid', 'spline'] | None
    degree: int | None
    def __init__(
        self,
        *,
        file: str | None = None,
        origin: Vector | None = None,
        axes: Points3 | None = None,
        lengths: Vector | None = None,
        counts: Sequence[int] | None = None,
        displacements: Points3 | None = None,
        mode: Literal['volume', 'rigid', 'spline'] | None = None,
        degree: int | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Pins(Stroke):
    points: Points3
    to: Points3
    radius: float | Literal['auto']
    turn: Sequence[Mapping[str, Any] | None] | None
    def __init__(
        self,
        *,
        points: Points3,
        to: Points3,
        radius: float | Literal['auto'],
        turn: Sequence[Mapping[str, Any] | None] | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Pose(Stroke):
    detail: float | None
    tolerance: float | None
    parts: Sequence[Mapping[str, Any]]
    stiffness: Sequence[Mapping[str, Any]] | None
    exact: bool | None
    def __init__(
        self,
        *,
        parts: Sequence[Mapping[str, Any]],
        detail: float | None = None,
        tolerance: float | None = None,
        stiffness: Sequence[Mapping[str, Any]] | None = None,
        exact: bool | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Grid(Stroke):
    origin: Vector
    spacing: float
    counts: Sequence[int]
    coefficients: str
    end_coefficients: str | None
    growth: str | None
    def __init__(
        self,
        *,
        origin: Vector,
        spacing: float,
        counts: Sequence[int],
        coefficients: str,
        end_coefficients: str | None = None,
        growth: str | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Inflate(Stroke):
    points: Points3 | None
    radius: float
    volume: float | None
    depth: float | None
    def __init__(
        self,
        *,
        radius: float,
        points: Points3 | None = None,
        volume: float | None = None,
        depth: float | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Print(Stroke):
    text: str | None
    font: str | None
    file: str | None
    point: Vector | None
    up: Vector | None
    direction: Vector | None
    height: float
    depth: float
    bump: float | None
    outer: float | None
    flip: bool | None
    def __init__(
        self,
        *,
        height: float,
        depth: float,
        text: str | None = None,
        font: str | None = None,
        file: str | None = None,
        point: Vector | None = None,
        up: Vector | None = None,
        direction: Vector | None = None,
        bump: float | None = None,
        outer: float | None = None,
        flip: bool | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
        mirror: Mirror | None = None,
    ) -> None: ...

class Relax(Stroke):
    points: Points3
    radius: float
    amount: float | None
    surface: float | None
    iterations: int | None
    def __init__(
        self,
        *,
        points: Points3,
        radius: float,
        amount: float | None = None,
        surface: float | None = None,
        iterations: int | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
    ) -> None: ...

class Mask(Stroke):
    points: Points3 | None
    vertices: Sequence[int | Sequence[int]] | None
    values: Sequence[float] | None
    width: float | None
    def __init__(
        self,
        *,
        points: Points3 | None = None,
        vertices: Sequence[int | Sequence[int]] | None = None,
        values: Sequence[float] | None = None,
        width: float | None = None,
        name: str | None = None,
        off: bool | None = None,
        strength: float | None = None,
        duration: float | None = None,
        new_entry: bool | None = None,
    ) -> None: ...

Strokes = Session | Stroke | Iterable[Stroke | Mapping[str, Any]]

class Session(MutableSequence[Stroke]):
    mesh: str | None
    note: str | None
    path: str | None
    def __init__(
        self,
        strokes: Stroke | Mapping[str, Any] | Iterable[Stroke | Mapping[str, Any]] = (),
        mesh: Path | None = None,
        note: str | None = None,
        parameters: Mapping[str, float | tuple[float, float | None, float | None]] | None = None,
        walls: Iterable[Mapping[str, Any]] | None = None,
    ) -> None: ...
    @property
    def parameters(self) -> dict[str, float]: ...
    @property
    def bounds(self) -> dict[str, tuple[float | None, float | None]]: ...
    @property
    def walls(self) -> list[dict[str, Any]]: ...
    def __call__(self, **values: float) -> Session: ...
    def jvp(
        self,
        points: Points_,
        direction: Mapping[str, float] | Sequence[float] | NDArray[Any],
        *,
        relative_tolerance: float = 1e-8,
        threads: int = 0,
        diagonal: float | None = None,
        progress: Progress | None = None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    @overload
    def vjp(
        self,
        points: Points_,
        gradient: ArrayLike,
        *,
        of_points: Literal[False] = False,
        relative_tolerance: float = 1e-8,
        threads: int = 0,
        diagonal: float | None = None,
        progress: Progress | None = None,
    ) -> dict[str, float]: ...
    @overload
    def vjp(
        self,
        points: Points_,
        gradient: ArrayLike,
        *,
        of_points: Literal[True],
        relative_tolerance: float = 1e-8,
        threads: int = 0,
        diagonal: float | None = None,
        progress: Progress | None = None,
    ) -> tuple[NDArray[np.float64], dict[str, float]]: ...
    @classmethod
    def read(cls, path: Path) -> Session: ...
    @classmethod
    def parse(cls, text: str, name: Path = "session") -> Session: ...
    def text(self) -> str: ...
    def write(self, path: Path) -> None: ...
    def resolve(self, vertices: Points_, faces: Faces | None = None, *, threads: int = 0) -> Session: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Stroke]: ...
    @overload
    def __getitem__(self, index: int) -> Stroke: ...
    @overload
    def __getitem__(self, index: slice) -> Session: ...
    def __setitem__(self, index: Any, value: Any) -> None: ...
    def __delitem__(self, index: int | slice) -> None: ...
    def insert(self, index: int, value: Stroke | Mapping[str, Any]) -> None: ...

class _Attributes(list[str]):
    @overload
    def __getitem__(self, name: str) -> NDArray[Any]: ...
    @overload
    def __getitem__(self, name: SupportsIndex) -> str: ...
    @overload
    def __getitem__(self, name: slice) -> list[str]: ...
    def __setitem__(self, name: str, values: ArrayLike) -> None: ...  # type: ignore[override]

class Shape:
    def __init__(self, vertices: Points_, faces: Faces | None = None) -> None: ...
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @vertices.setter
    def vertices(self, vertices: ArrayLike) -> None: ...
    @property
    def faces(self) -> NDArray[np.uint32] | list[NDArray[np.uint32]]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def patches(self) -> dict[str, NDArray[np.uint32]]: ...
    @property
    def attributes(self) -> _Attributes: ...
    @property
    def splats(self) -> Splats: ...
    @property
    def format(self) -> str: ...
    @property
    def notes(self) -> list[str]: ...
    def write(self, path: Path, *, double: bool = False, decimals: int | None = None) -> None: ...

class Splats:
    means: Any
    scales: Any
    rotations: Any
    harmonics: Any
    opacities: Any
    def __init__(self, means: Any, scales: Any, rotations: Any, harmonics: Any = None, opacities: Any = None) -> None: ...
    def __len__(self) -> int: ...
    def write(self, path: Path) -> None: ...

def read(path: Path) -> Shape: ...
def write(path: Path, vertices: Points_, faces: Faces | None = None, *, double: bool = False) -> None: ...
class Measure:
    def __init__(self, native: Any) -> None: ...
    @property
    def values(self) -> NDArray[np.float64]: ...
    def jvp(self, tangents: Points_) -> NDArray[np.float64]: ...
    def vjp(self, weights: ArrayLike = 1.0) -> NDArray[np.float64]: ...
    def __float__(self) -> float: ...
    def __len__(self) -> int: ...

def volume_of(vertices: Points_, faces: Faces | None = None) -> Measure: ...
def area_of(vertices: Points_, faces: Faces | None = None) -> Measure: ...
def thickness_at(vertices: Points_, at: ArrayLike, faces: Faces | None = None) -> Measure: ...
def curvature(vertices: Points_, at: ArrayLike, faces: Faces | None = None) -> Measure: ...
def patch_distance(vertices: Points_, at: ArrayLike, patch: Faces) -> Measure: ...
def check(vertices: Points_, faces: Faces | None = None) -> dict[str, Any]: ...
def check_cells(points: Points_, cells: Any, before: Points_ | None = None) -> dict[str, NDArray[Any]]: ...
def crossings(vertices: Points_, faces: Faces | None = None) -> NDArray[np.uint32]: ...
def frames(
    vertices: Points_,
    session: Strokes,
    n: int,
    faces: Faces | None = None,
    *,
    ease: Literal["linear", "smooth"] = "linear",
    hold: int = 0,
    progress: Callable[[float], Any] | None = None,
    **accuracy: Any,
) -> NDArray[np.float64]: ...
def write_frames(path: Path, frames: ArrayLike, faces: Faces | None = None, *, fps: float = 24) -> None: ...
def animate(
    path: Path,
    vertices: Points_,
    session: Strokes,
    n: int,
    faces: Faces | None = None,
    *,
    fps: float = 24,
    ease: Literal["linear", "smooth"] = "linear",
    hold: int = 0,
    progress: Callable[[float], Any] | None = None,
    **accuracy: Any,
) -> bool: ...
@overload
def deform(
    vertices: Points_,
    session: Strokes,
    faces: Faces | None = None,
    *,
    relative_tolerance: float = 1e-5,
    precision: Precision = "float32",
    integrator: Integrator = "tsit5",
    threads: int = 0,
    inverse: bool = False,
    until: float | None = None,
    diagonal: float | None = None,
    progress: Progress | None = None,
    out: NDArray[np.floating[Any]] | None = None,
    also: None = None,
    patches: Mapping[str, ArrayLike] | None = None,
    cells: Any = None,
) -> NDArray[np.floating[Any]]: ...
@overload
def deform(
    vertices: Points_,
    session: Strokes,
    faces: Faces | None = None,
    *,
    relative_tolerance: float = 1e-5,
    precision: Precision = "float32",
    integrator: Integrator = "tsit5",
    threads: int = 0,
    inverse: bool = False,
    until: float | None = None,
    diagonal: float | None = None,
    progress: Progress | None = None,
    out: NDArray[np.floating[Any]] | None = None,
    also: Iterable[Points_],
) -> list[NDArray[np.floating[Any]]]: ...

class Flow:
    def __init__(self, session: Strokes = ()) -> None: ...
    def __call__(
        self,
        points: Points_,
        *,
        relative_tolerance: float = 1e-5,
        precision: Precision = "float32",
        integrator: Integrator = "tsit5",
        threads: int = 0,
        diagonal: float | None = None,
        progress: Progress | None = None,
        out: NDArray[np.floating[Any]] | None = None,
    ) -> NDArray[np.floating[Any]]: ...
    def inverse(self) -> Flow: ...
    def part(self, begin: float, end: float) -> Flow: ...
    def path(
        self,
        points: Points_,
        n: int,
        *,
        relative_tolerance: float = 1e-5,
        precision: Precision = "float32",
        integrator: Integrator = "tsit5",
        threads: int = 0,
        diagonal: float | None = None,
    ) -> NDArray[np.float64]: ...
    def velocity(self, points: Points_, time: float) -> NDArray[np.float64]: ...
    def jacobian(
        self,
        points: Points_,
        *,
        relative_tolerance: float = 1e-5,
        precision: Precision = "float32",
        integrator: Integrator = "tsit5",
        threads: int = 0,
        diagonal: float | None = None,
    ) -> NDArray[np.float64]: ...
    def jvp(
        self,
        points: Points_,
        direction: Sequence[ArrayLike | None],
        *,
        relative_tolerance: float = 1e-8,
        threads: int = 0,
        diagonal: float | None = None,
        progress: Progress | None = None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def vjp(
        self,
        points: Points_,
        gradient: ArrayLike,
        *,
        relative_tolerance: float = 1e-8,
        threads: int = 0,
        diagonal: float | None = None,
        progress: Progress | None = None,
    ) -> tuple[NDArray[np.float64], list[NDArray[np.float64] | None]]: ...
    def __len__(self) -> int: ...
    def __add__(self, other: Flow) -> Flow: ...

class Posed:
    vertices: NDArray[np.float64]
    session: Session
    report: dict[str, Any]
    linear: NDArray[np.float64]
    dual: NDArray[np.float64]
    corrective: NDArray[np.float64]

class Corrective:
    bones: NDArray[np.uint32]
    axes: NDArray[np.float64]
    angles_deg: NDArray[np.float64]
    offsets: NDArray[np.float64]

def skin(
    vertices: Points_,
    faces: Faces | None,
    weights: Any,
    rest: ArrayLike,
    poses: ArrayLike,
    *,
    parents: ArrayLike | None = None,
    rigid_weight: float = 0.9,
    detail: float = 0,
    measured: bool = True,
    threads: int = 0,
    progress: Progress | None = None,
) -> Posed | list[Posed] | None: ...
def correctives(
    vertices: Points_,
    faces: Faces | None,
    weights: Any,
    rest: ArrayLike,
    pose: ArrayLike,
    *,
    parents: ArrayLike | None = None,
    rigid_weight: float = 0.9,
    detail: float = 0,
    threads: int = 0,
    progress: Progress | None = None,
) -> list[Corrective] | None: ...

class Fit:
    session: Session
    vertices: NDArray[np.float64]
    also: list[NDArray[np.float64]]
    report: dict[str, Any]
    problem: str

@overload
def fit(
    source: Points_ | tuple[ArrayLike, Faces],
    target: Points_ | tuple[ArrayLike, Faces],
    landmarks: ArrayLike | None = None,
    map: ArrayLike | None = None,
    *,
    volume: Literal["keep", "total", "free"] = "keep",
    align: bool | Literal["auto", "always", "never"] = True,
    surface: bool = True,
    partial: bool = False,
    also: Iterable[Points_] = (),
    max_stretch: float = 5,
    threads: int = 0,
    progress: None = None,
) -> Fit: ...
@overload
def fit(
    source: Points_ | tuple[ArrayLike, Faces],
    target: Points_ | tuple[ArrayLike, Faces],
    landmarks: ArrayLike | None = None,
    map: ArrayLike | None = None,
    *,
    volume: Literal["keep", "total", "free"] = "keep",
    align: bool | Literal["auto", "always", "never"] = True,
    surface: bool = True,
    partial: bool = False,
    also: Iterable[Points_] = (),
    max_stretch: float = 5,
    threads: int = 0,
    progress: Progress,
) -> Fit | None: ...

class Population:
    template: tuple[NDArray[np.float64], Faces]
    fits: list[Fit]
    aligned: NDArray[np.float64]
    mean: Fit
    modes: NDArray[np.float64]
    deviations: NDArray[np.float64]
    weights: NDArray[np.float64]
    def along(self, weights: ArrayLike, *, progress: Progress | None = None) -> Fit: ...

def mean(
    shapes: Iterable[Points_ | tuple[ArrayLike, Faces]],
    *,
    template: int | Points_ | tuple[ArrayLike, Faces] = 0,
    landmarks: Iterable[ArrayLike | None] | None = None,
    maps: Iterable[ArrayLike | None] | None = None,
    volume: Literal["keep", "free"] = "free",
    align: bool | Literal["auto", "always", "never"] = True,
    max_stretch: float = 5,
    threads: int = 0,
    progress: Progress | None = None,
) -> Population | None: ...

class Remeshed:
    vertices: NDArray[np.float64]
    faces: NDArray[np.uint32] | list[NDArray[np.uint32]]
    face_source: NDArray[np.uint32]
    report: dict[str, Any]

def remesh(
    vertices: Points_,
    faces: Faces | None = None,
    session: Strokes | None = None,
    *,
    max_edge: float | None = None,
    max_angle_deg: float | None = None,
    max_chord: float | None = None,
    min_edge: float | None = None,
    iterations: int | None = None,
    max_vertices: int | None = None,
    seconds: float | None = None,
    relative_tolerance: float = 1e-5,
    precision: Precision = "float32",
    integrator: Integrator = "tsit5",
    threads: int = 0,
    progress: Progress | None = None,
) -> Remeshed: ...
def lattice_points(stroke: Lattice) -> NDArray[np.float64]: ...
def certify(
    before: Points_,
    after: Points_,
    faces: Faces,
    session: Strokes,
    *,
    relative_tolerance: float = 1e-5,
    precision: Precision = "float32",
    integrator: Integrator = "tsit5",
    threads: int = 0,
    progress: Progress | None = None,
) -> dict[str, Any]: ...
def render(
    shape: Shape | Points_,
    faces: Faces | None = None,
    *,
    session: Strokes | None = None,
    size: tuple[int, int] = (800, 600),
    view: tuple[float, float] = (30, 20),
    up: Literal["y", "z"] = "y",
    perspective: float = 25,
    background: str = "white",
    material: str = "clay",
    ground: bool = True,
    wireframe: bool = False,
    flat: bool = False,
    cavity: bool = False,
    occlusion: bool = False,
) -> NDArray[np.uint8]: ...

class Workbench:
    def __init__(self, vertices: Points_, faces: Faces | None = None, *, folder: Path = "") -> None: ...
    def set_live(self, strokes: Strokes) -> None: ...
    def finish(self) -> None: ...
    def undo(self) -> bool: ...
    def redo(self) -> bool: ...
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def faces(self) -> NDArray[np.uint32] | list[NDArray[np.uint32]]: ...
    @property
    def session(self) -> Session: ...

class Surface:
    def __init__(self, vertices: Points_, faces: Faces | None = None) -> None: ...
    def move(self, vertices: Points_) -> None: ...
    def hit(self, origin: Vector, direction: Vector) -> tuple[list[float], list[float]] | None: ...
    def middle(self, origin: Vector, direction: Vector) -> list[float] | None: ...
    def thickness(self, point: Vector, normal: Vector) -> float | None: ...
    def ring(self, point: Vector, normal: Vector, radius: float, count: int = 64) -> NDArray[np.float64]: ...
    def part(
        self, point: Vector, direction: Vector, *, axis: Vector = (0, 0, 0), angle_deg: float = 0
    ) -> dict[str, Any]: ...
    def with_safe_zone(self, stroke: _S) -> _S: ...

class PaintDrag:
    def __init__(
        self,
        *,
        outer: float,
        depth: float,
        falloff: int | Literal["wide"] = 4,
        pinch: float = 0.0,
        surface: Surface | None = None,
    ) -> None: ...
    def touch(self, point: Vector, normal: Vector, *, outer: float | None = None, pressure: float = 1.0) -> None: ...
    def finish(self) -> None: ...
    @property
    def spacing(self) -> float: ...
    @property
    def strokes(self) -> list[Stroke]: ...

def brush(
    name: Literal["move", "snakehook", "paint", "crease", "pinch", "flatten"],
    path: Sequence[Vector],
    *,
    radius: float,
    amount: float | None = None,
) -> Stroke: ...
def symmetric(
    strokes: Strokes,
    planes: str,
    *,
    size: float | None = None,
    image_file: Any = None,
) -> list[Stroke]: ...

def deform_cells(
    points: Points_,
    cells: Any,
    session: Strokes,
    *,
    least_scaled_jacobian: float = 0.05,
    fixed: Any = None,
    relative_tolerance: float = 1e-5,
    precision: str = "float64",
    integrator: str = "tsit5",
    threads: int = 0,
    until: float | None = None,
    diagonal: float | None = None,
    progress: Progress | None = None,
) -> tuple[Any, Any]: ...
def safe_until(
    points: Points_,
    cells: Any,
    session: Strokes,
    *,
    least_scaled_jacobian: float = 0,
    inverse: bool = False,
    relative_tolerance: float = 1e-5,
    precision: str = "float64",
    integrator: str = "tsit5",
    threads: int = 0,
    until: float | None = None,
    diagonal: float | None = None,
    progress: Progress | None = None,
) -> dict[str, Any] | None: ...
def widest_outer(points: Points_, cells: Any, stroke: Stroke) -> float | None: ...
def from_build123d(part: Any, tolerance: float | None = None) -> Shape: ...
def deform_mesh(
    mesh: _Mesh,
    session: Strokes,
    *,
    least_scaled_jacobian: float | None = None,
    report: dict[str, Any] | None = None,
    **options: Any,
) -> _Mesh: ...
