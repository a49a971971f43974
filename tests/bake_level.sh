# A mesh to bake, and a scene of it, for tests of bakes. Sourced.

# Two quads, floor and wall, in one glTF mesh of two primitives with second texture coordinates in one map, and a third
# quad without, which two nodes share.
make_level() {
  python3 - << 'END'
import json, struct
def quad(o, u, v): return [o, [a + b for a, b in zip(o, u)], [a + b + c for a, b, c in zip(o, u, v)], [a + c for a, c in zip(o, v)]]
blob = b''
views, accessors = [], []
def add(rows, kind, code):
    global blob
    data = b''.join(struct.pack('<' + code * len(r), *r) for r in rows)
    blob += b'\0' * (-len(blob) % 4)
    views.append({'buffer': 0, 'byteOffset': len(blob), 'byteLength': len(data)})
    blob += data
    accessors.append({'bufferView': len(views) - 1, 'componentType': {'f': 5126, 'H': 5123}[code], 'count': len(rows), 'type': kind})
    if code == 'f' and kind == 'VEC3':
        accessors[-1]['min'] = [min(c) for c in zip(*rows)]
        accessors[-1]['max'] = [max(c) for c in zip(*rows)]
    return len(accessors) - 1
corners = add([[i] for i in (0, 1, 2, 0, 2, 3)], 'SCALAR', 'H')
floor = add(quad([-1, 0, -1], [0, 0, 2], [2, 0, 0]), 'VEC3', 'f')
wall = add(quad([-1, 0, -1], [2, 0, 0], [0, 2, 0]), 'VEC3', 'f')
left = add(quad([0.05, 0.05], [0.4, 0], [0, 0.9]), 'VEC2', 'f')
right = add(quad([0.55, 0.05], [0.4, 0], [0, 0.9]), 'VEC2', 'f')
sign = add(quad([-0.2, 0.5, 0], [0.4, 0, 0], [0, 0.4, 0]), 'VEC3', 'f')
def part(positions, uv): return {'attributes': {'POSITION': positions, **({'TEXCOORD_1': uv} if uv else {})}, 'indices': corners}
def level(signs, uv):
    return {'asset': {'version': '2.0'}, 'scene': 0, 'scenes': [{'nodes': list(range(1 + signs))}],
        'nodes': [{'mesh': 0}] + [{'mesh': 1, 'translation': [0, 0.3 * i, 0.4 * i]} for i in range(signs)],
        'meshes': [{'name': 'the room/1', 'primitives': [part(floor, uv and left), part(wall, uv and right)]}] +
                  ([{'name': 'sign', 'primitives': [part(sign, None)]}] if signs else []),
        'accessors': accessors, 'bufferViews': views, 'extras': {'kept': [1, 2.5]}}
def glb(name, j):
    j = dict(j, buffers=[{'byteLength': len(blob)}])
    text = json.dumps(j).encode(); text += b' ' * (-len(text) % 4)
    body = blob + b'\0' * (-len(blob) % 4)
    open(name, 'wb').write(struct.pack('<III', 0x46546C67, 2, 28 + len(text) + len(body)) +
                           struct.pack('<II', len(text), 0x4E4F534A) + text + struct.pack('<II', len(body), 0x4E4942) + body)
glb('level.glb', level(2, True))
glb('plain.glb', level(1, False))
open('apart.bin', 'wb').write(blob)
json.dump(dict(level(1, True), buffers=[{'byteLength': len(blob), 'uri': 'apart.bin'}]), open('apart.gltf', 'w'))
END
  cat > level.json << 'END'
{"tyndall": 1, "geometry": [{"file": "level.glb"}],
 "lights": [{"type": "point", "position": [0.3, 1.5, 0.2], "intensity": [3, 2, 1]}]}
END
}
