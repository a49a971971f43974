"""Tyndall for Blender: exports scenes, and renders them by the program `tyndall` in a process of its own."""
bl_info = {
    "name": "Tyndall",
    "author": "The Tyndall authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render properties, File > Export > Tyndall",
    "description": "Light in fog, smoke, clouds, milk and water, with a known error",
    "doc_url": "",
    "category": "Render",
}


def _modules():
    from . import chain, engine, operators, panels, settings
    return settings, chain, engine, operators, panels


def register():
    for module in _modules():
        module.register()


def unregister():
    for module in reversed(_modules()):
        module.unregister()
