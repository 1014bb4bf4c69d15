"""Everything that differs between Blender 3.4 and 4.x."""


def sculpt_mask(mesh):
    """Returns the data of the sculpt mask, each with .value, or None. Since 4.1 it is a named attribute."""
    attribute = mesh.attributes.get(".sculpt_mask")
    if attribute is not None:
        return attribute.data
    layers = getattr(mesh, "vertex_paint_masks", None)
    return layers[0].data if layers else None
