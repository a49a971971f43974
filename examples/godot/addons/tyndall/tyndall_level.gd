## A level that `tyndall bake` lit, `tyndall export --for godot` listed and `tyndall fluence` filled with fog.
##
## The folder holds export.json with its lightmaps (.dds), the glTF of vertex colours, and fog.json with fog.dds. Materials
## become unshaded: a lightmap is irradiance over pi, which albedo makes radiance.
class_name TyndallLevel
extends Node3D

@export_dir var folder := "res://files"
## Radiance is multiplied by two to this power.
@export var exposure := 1.0

const LIGHTMAP := preload("res://addons/tyndall/lightmap.gdshader")
const VERTEX_LIGHT := preload("res://addons/tyndall/vertex_light.gdshader")
const FOG := preload("res://addons/tyndall/fog.gdshader")

var _gain := 1.0


func _ready() -> void:
	_gain = pow(2.0, exposure)
	var files := _read("export.json")
	if files.is_empty() or files.get("engine") != "godot":
		push_error("%s: no export for Godot" % folder)
		return
	var state := GLTFState.new()
	var document := GLTFDocument.new()
	if document.append_from_file(folder.path_join(files["vertex_colors"]), state) != OK:
		push_error("%s: cannot be read" % files["vertex_colors"])
		return
	var level := document.generate_scene(state)
	add_child(level)
	var lit := {}
	for map: Dictionary in files["lightmaps"]:
		var texture := load(folder.path_join(map["file"])) as Texture2D
		for mesh: Dictionary in map["meshes"]:
			var node_name: String = state.get_nodes()[int(mesh["node"])].resource_name
			var instance := level.find_child(node_name, true, false) as MeshInstance3D
			if instance == null:
				push_warning("%s: the level has no mesh of this name" % node_name)
				continue
			_set_material(instance, int(mesh["primitive"]), LIGHTMAP, {"lightmap": texture, "gain": _gain})
			lit[instance] = true
	for instance: MeshInstance3D in find_children("*", "MeshInstance3D", true, false):
		if not lit.has(instance):
			var scale := _gain / (PI * float(files["color_scale"]))
			for surface in instance.mesh.get_surface_count():
				_set_material(instance, surface, VERTEX_LIGHT, {"gain": scale})
	for lamp: Light3D in find_children("*", "Light3D", true, false):
		lamp.queue_free() # it is baked
	var cameras := find_children("*", "Camera3D", true, false)
	if not cameras.is_empty():
		(cameras[0] as Camera3D).make_current()
	_add_fog()


## The coefficients of the nearest probe: nine terms of radiance over pi, in the order of LightmapGI's light probes.
func nearest_probe(at: Vector3) -> PackedColorArray:
	var nearest := PackedColorArray()
	var smallest := INF
	for probe: Dictionary in _read("grid.json").get("probes", []):
		var p: Array = probe["position"]
		var distance := at.distance_squared_to(Vector3(p[0], p[1], p[2]))
		if distance >= smallest or float(probe["blocked"]) > 0.5:
			continue
		smallest = distance
		nearest.clear()
		for term in 9:
			var c: Array = probe["coefficients"].slice(3 * term, 3 * term + 3)
			nearest.append(Color(c[0], c[1], c[2]))
	return nearest


## What a white surface with a normal reflects, by the formula of Godot's own shader of light probes.
static func probe_light(sh: PackedColorArray, n: Vector3) -> Color:
	return (sh[0] * 0.886227 + (sh[1] * n.y + sh[2] * n.z + sh[3] * n.x) * 1.023327
			+ (sh[4] * n.x * n.y + sh[5] * n.y * n.z + sh[7] * n.x * n.z) * 0.858086
			+ sh[6] * 0.247708 * (3.0 * n.z * n.z - 1.0) + sh[8] * 0.429043 * (n.x * n.x - n.y * n.y))


func _read(file: String) -> Dictionary:
	var content: Variant = JSON.parse_string(FileAccess.get_file_as_string(folder.path_join(file)))
	return content if content is Dictionary else {}


func _set_material(instance: MeshInstance3D, surface: int, shader: Shader, values: Dictionary) -> void:
	var material := ShaderMaterial.new()
	material.shader = shader
	for key: String in values:
		material.set_shader_parameter(key, values[key])
	var from := instance.get_active_material(surface) as BaseMaterial3D
	if from != null:
		material.set_shader_parameter("albedo", from.albedo_color)
		if from.albedo_texture != null:
			material.set_shader_parameter("albedo_texture", from.albedo_texture)
	instance.set_surface_override_material(surface, material)


## A quad in front of all else marches through the fog up to the depth of each pixel.
func _add_fog() -> void:
	var fog := _read("fog.json")
	if fog.is_empty():
		return
	var material := ShaderMaterial.new()
	material.shader = FOG
	material.render_priority = Material.RENDER_PRIORITY_MAX
	material.set_shader_parameter("fog", load(folder.path_join(fog["texture"])) as Texture3D)
	material.set_shader_parameter("lower", Vector3(fog["lower"][0], fog["lower"][1], fog["lower"][2]))
	material.set_shader_parameter("upper", Vector3(fog["upper"][0], fog["upper"][1], fog["upper"][2]))
	material.set_shader_parameter("gain", _gain)
	var quad := MeshInstance3D.new()
	quad.mesh = QuadMesh.new()
	quad.mesh.size = Vector2(2, 2)
	quad.material_override = material
	quad.extra_cull_margin = 16384
	add_child(quad)
