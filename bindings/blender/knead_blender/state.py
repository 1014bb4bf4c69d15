# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object keeps of its session. It lies in the mesh, so that linked duplicates share it."""

import bpy
import numpy as np
from bpy.props import BoolProperty, CollectionProperty, FloatVectorProperty, IntProperty, PointerProperty, StringProperty

from . import shape, shown
from .native import knead
from .shape import Refusal


def parse(text):
    """Returns the session that a text holds; an empty text is a session without strokes."""
    return knead.Session.parse(text) if text else knead.Session()


def _toggle(stroke, context):
    mesh = stroke.id_data
    if mesh.knead.is_listing:
        return
    index = list(mesh.knead.strokes).index(stroke)
    obj = context.object  # the panel may show another object's mesh
    if obj is None or obj.data != mesh:
        obj = next(each for each in context.scene.objects if each.data == mesh)
    with context.temp_override(object=obj, active_object=obj):
        bpy.ops.knead.stroke_off("EXEC_DEFAULT", True, index=index, off=not stroke.on)


class KneadStroke(bpy.types.PropertyGroup):
    """A line of the list in the panel."""

    on: BoolProperty(name="On", description="Whether the stroke is applied", update=_toggle)


def _list_strokes(self, _context=None):
    self.is_listing = True
    try:
        self.strokes.clear()
        for stroke in parse(self.session):
            item = self.strokes.add()
            item.name = stroke.to_dict().get("name") or stroke.tool
            item.on = not stroke.off
        self.active = min(self.active, max(0, len(self.strokes) - 1))
    finally:
        self.is_listing = False


class KneadMesh(bpy.types.PropertyGroup):
    session: StringProperty(name="Session", description="The strokes, as the text of a .knead file", update=_list_strokes)
    pins: StringProperty(name="Pins", description="The numbers of the vertices that stay in poses, as a JSON list")
    key: StringProperty(name="Shape key", description="The shape key that the strokes edit")
    space: StringProperty(name="Space", description="LOCAL, or WORLD: the strokes are in the frame below")
    frame: FloatVectorProperty(name="Frame", size=16, default=[float(i % 5 == 0) for i in range(16)])
    result: StringProperty(name="Result", description="Fingerprint of the vertices that the session gave")
    is_posed: BoolProperty(name="Posed", description="The base and the strokes are those of the mesh as it was shown, not of its own vertices")
    seen: StringProperty(name="Seen", description="Fingerprint of the vertices that were shown then, of a posed mesh")
    strokes: CollectionProperty(type=KneadStroke)
    active: IntProperty(name="Active stroke", min=0)
    is_listing: BoolProperty(options={"SKIP_SAVE", "HIDDEN"})


def _get_session(self):
    mesh = self.id_data.data
    return mesh.knead.session if isinstance(mesh, bpy.types.Mesh) else ""


def _set_session(self, text):
    mesh = self.id_data.data
    if not isinstance(mesh, bpy.types.Mesh):
        raise TypeError("only meshes have a session")
    parse(text)
    mesh.knead.session = text


class KneadObject(bpy.types.PropertyGroup):
    session: StringProperty(name="Session", description="The strokes of the object's mesh", get=_get_session, set=_set_session)
    report: StringProperty(name="Report", description="What knead.check found", options={"SKIP_SAVE"})


def frame_of(mesh):
    """Returns the frame in which the strokes of a mesh are."""
    if mesh.knead.space != "WORLD":
        return shape.Frame()
    m = list(mesh.knead.frame)
    return shape.Frame([m[4 * i : 4 * i + 4] for i in range(4)])


def frame_for(obj, space):
    """Returns the frame that a session which begins now has."""
    return shape.Frame(obj.matrix_world) if space == "WORLD" else shape.Frame()


def require_mesh(obj):
    """Raises Refusal where strokes cannot be applied to the object."""
    if obj is None or obj.type != "MESH":
        raise Refusal("Knead needs a mesh object; select one")
    if obj.mode not in {"OBJECT", "SCULPT"}:
        raise Refusal("Knead works in object and sculpt mode; press Tab to leave this mode")
    if obj.library is not None or obj.data.library is not None:
        raise Refusal("The mesh is linked from another file; make it local first")
    if obj.mode == "SCULPT" and (obj.use_dynamic_topology_sculpting or any(m.type == "MULTIRES" for m in obj.modifiers)):
        raise Refusal("Knead edits the base mesh; end dynamic topology or leave sculpt mode of the multires modifier")
    if len(obj.data.vertices) == 0:
        raise Refusal("The mesh has no vertices")


def changed_elsewhere(obj):
    """Returns whether the vertices differ from what the session gave."""
    data = obj.data.knead
    return bool(data.session) and shape.fingerprint(shape.read(obj)) != data.result


def extends(obj):
    """Returns whether strokes go on with the session of the mesh. Raises Refusal for one of another key or pose."""
    if not obj.data.knead.session or shape.read_base(obj.data) is None or changed_elsewhere(obj):
        return False
    require_own_key(obj)
    require_pose(obj)
    return True


def require_pose(obj):
    """Raises Refusal where the mesh is not shown as the session left it, although its vertices are where it left them."""
    data = obj.data.knead
    if not data.session or changed_elsewhere(obj):
        return
    if shape.fingerprint(shown.read(obj)) != (data.seen if data.is_posed else data.result):
        raise Refusal("The session was made in another pose; go back to its pose, frame and shape keys, or clear the session")


def to_edit(obj, coordinates):
    """Returns the coordinates to edit for those that the session gives. Raises Refusal where a session of a posed mesh is
    rebuilt in another pose; one of the mesh's own vertices is the same in each."""
    data = obj.data.knead
    if data.session and not data.is_posed:
        return coordinates
    require_pose(obj)
    return shown.follow(obj, coordinates)


def require_own_key(obj):
    data = obj.data.knead
    if data.session and data.key != shape.key_name(obj):
        name = data.key or "the mesh itself"
        raise Refusal(f"The session belongs to {name}; make that active, or clear the session")


def require_space(mesh, space):
    """Raises Refusal for strokes in the world's space after others in the object's own."""
    if space == "WORLD" and mesh.knead.space != "WORLD":
        raise Refusal("The session is in the object's own space; clear it before one in the world's space")


def begin(obj, space="LOCAL"):
    """Begins a session: keeps the base positions, which are those shown, the shape key and the frame. What edits a posed
    mesh is a shape key, so that the mesh itself stays as it is."""
    data = obj.data.knead
    base = shown.read(obj)
    data.is_posed = not np.array_equal(base, shape.read(obj))
    if data.is_posed and obj.data.shape_keys is None:
        shape.add_key(obj, "Knead")
    data.session = ""
    data.key = shape.key_name(obj)
    data.space = space
    if space == "WORLD":
        data.frame = [x for row in obj.matrix_world for x in row]
    shape.write_base(obj.data, base)


def keep(obj, session, coordinates):
    """Writes the coordinates to edit that a session gives, and the session."""
    shape.write(obj, coordinates)
    obj.data.knead.session = session.text() if len(session) else ""
    note_result(obj)
    obj.knead.report = ""


def note_result(obj):
    """Takes the mesh as it is for what the session gave."""
    data = obj.data.knead
    data.key = shape.key_name(obj)
    data.result = shape.fingerprint(shape.read(obj))
    data.seen = shape.fingerprint(shown.read(obj)) if data.is_posed else ""


_CLASSES = (KneadStroke, KneadMesh, KneadObject)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Mesh.knead = PointerProperty(type=KneadMesh)
    bpy.types.Object.knead = PointerProperty(type=KneadObject)


def unregister():
    del bpy.types.Object.knead
    del bpy.types.Mesh.knead
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
