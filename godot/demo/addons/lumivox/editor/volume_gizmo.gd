@tool
extends EditorNode3DGizmoPlugin
## A volume's box, its clip box with a handle on each face, and the patient's directions.

## Letters of the ends of the node's axes: a patient stands upright and faces +z.
const LETTERS: Dictionary[String, Vector3] = {
	"L": Vector3.RIGHT, "R": Vector3.LEFT, "H": Vector3.UP, "F": Vector3.DOWN, "A": Vector3.BACK, "P": Vector3.FORWARD,
}
## Strokes of the letters in a unit square.
const STROKES: Dictionary[String, PackedVector2Array] = {
	"L": [Vector2(0, 1), Vector2(0, 0), Vector2(0, 0), Vector2(0.6, 0)],
	"R": [Vector2(0, 0), Vector2(0, 1), Vector2(0, 1), Vector2(0.6, 0.95), Vector2(0.6, 0.95), Vector2(0.6, 0.5),
		Vector2(0.6, 0.5), Vector2(0, 0.5), Vector2(0.2, 0.5), Vector2(0.6, 0)],
	"H": [Vector2(0, 0), Vector2(0, 1), Vector2(0.6, 0), Vector2(0.6, 1), Vector2(0, 0.5), Vector2(0.6, 0.5)],
	"F": [Vector2(0, 0), Vector2(0, 1), Vector2(0, 1), Vector2(0.6, 1), Vector2(0, 0.5), Vector2(0.5, 0.5)],
	"A": [Vector2(0, 0), Vector2(0.3, 1), Vector2(0.3, 1), Vector2(0.6, 0), Vector2(0.12, 0.4), Vector2(0.48, 0.4)],
	"P": [Vector2(0, 0), Vector2(0, 1), Vector2(0, 1), Vector2(0.6, 0.95), Vector2(0.6, 0.95), Vector2(0.6, 0.5),
		Vector2(0.6, 0.5), Vector2(0, 0.5)],
}
const MIN_EXTENT := 0.002
## A node without a scan, in metres: about a head.
const PLACEHOLDER := AABB(Vector3(-0.12, -0.12, -0.12), Vector3(0.24, 0.24, 0.24))
const CLIP_NAMES: PackedStringArray = [
	"Clip right", "Clip left", "Clip feet", "Clip head", "Clip back", "Clip front",
]

## Pixels of a box's diagonal on the screen below which it is too small to be clipped by hand: handles would cover it.
const LEAST_DIAGONAL := 40.0
## Size of a handle as a part of that diagonal, up to the size of the editor's other handles.
const HANDLE_PART := 0.12

var _undo: EditorUndoRedoManager
## Handles as large as their box allows in whichever viewport; the engine's own are so many pixels, however small the box is.
var _handle_shader := preload("volume_handles.gdshader")


func _init(undo: EditorUndoRedoManager = null) -> void:
	_undo = undo
	create_material("box", Color(0.96, 0.60, 0.42, 0.45))
	create_material("clip", Color(0.96, 0.72, 0.30))
	create_material("x", Color(0.96, 0.33, 0.36))
	create_material("y", Color(0.55, 0.84, 0.20))
	create_material("z", Color(0.30, 0.58, 0.98))


func _get_gizmo_name() -> String:
	return "LumivoxVolume3D"


func _has_gizmo(node: Node3D) -> bool:
	return node is LumivoxVolume3D


func _redraw(gizmo: EditorNode3DGizmo) -> void:
	gizmo.clear()
	var node := gizmo.get_node_3d() as LumivoxVolume3D
	var box := node.get_local_box()
	if box.size == Vector3.ZERO:
		# There is something to see and to click at, though there is no scan yet.
		gizmo.add_lines(_edges(PLACEHOLDER), get_material("box", gizmo))
		gizmo.add_collision_segments(_edges(PLACEHOLDER))
		return
	# An oblique scan's box is turned against the node.
	var place := node.get_clip_transform()
	gizmo.add_lines(place * _edges(AABB(Vector3.ZERO, Vector3.ONE)), get_material("box", gizmo))
	var shape := BoxMesh.new()
	shape.size = Vector3.ONE
	var triangles := TriangleMesh.new()
	triangles.create_from_faces(place.translated_local(Vector3.ONE / 2.0) * shape.get_faces())
	gizmo.add_collision_triangles(triangles)
	if node.clip_min != Vector3.ZERO or node.clip_max != Vector3.ONE:
		gizmo.add_lines(place * _edges(_clip_box(node)), get_material("clip", gizmo))
	var handles := PackedVector3Array()
	var ids := PackedInt32Array()
	for face in 6:
		handles.append(place * _face_center(_clip_box(node), face))
		ids.append(face)
	gizmo.add_handles(handles, _handle_material(box), ids)
	for letter in LETTERS:
		_add_letter(gizmo, box, letter)


func _get_handle_name(_gizmo: EditorNode3DGizmo, handle_id: int, _secondary: bool) -> String:
	return CLIP_NAMES[handle_id]


func _get_handle_value(gizmo: EditorNode3DGizmo, handle_id: int, _secondary: bool) -> Variant:
	var node := gizmo.get_node_3d() as LumivoxVolume3D
	return node.clip_max if handle_id % 2 == 1 else node.clip_min


func _set_handle(gizmo: EditorNode3DGizmo, handle_id: int, _secondary: bool, camera: Camera3D, at: Vector2) -> void:
	var node := gizmo.get_node_3d() as LumivoxVolume3D
	if diagonal_on_screen(node, camera) < LEAST_DIAGONAL:
		# No handle is seen there, but the engine takes hold of them all the same.
		return
	var axis := handle_id >> 1
	var to_clip := (node.global_transform * node.get_clip_transform()).affine_inverse()
	var origin := to_clip * camera.project_ray_origin(at)
	var along := (to_clip.basis * camera.project_ray_normal(at)) * 1e3
	var direction := Vector3.ZERO
	direction[axis] = 10.0
	var center := _face_center(_clip_box(node), handle_id)
	var closest := Geometry3D.get_closest_points_between_segments(
			center - direction, center + direction, origin, origin + along)
	var place := closest[0][axis]
	if EditorInterface.is_node_3d_snap_enabled():
		place = snappedf(place, 0.05)
	if handle_id % 2 == 1:
		var high := node.clip_max
		high[axis] = clampf(place, node.clip_min[axis] + MIN_EXTENT, 1.0)
		node.clip_max = high
	else:
		var low := node.clip_min
		low[axis] = clampf(place, 0.0, node.clip_max[axis] - MIN_EXTENT)
		node.clip_min = low
	node.update_gizmos()


func _commit_handle(gizmo: EditorNode3DGizmo, handle_id: int, _secondary: bool, restore: Variant, cancel: bool) -> void:
	var node := gizmo.get_node_3d() as LumivoxVolume3D
	var property := &"clip_max" if handle_id % 2 == 1 else &"clip_min"
	if cancel:
		node.set(property, restore)
		return
	_undo.create_action("Clip Volume", UndoRedo.MERGE_DISABLE, node)
	_undo.add_do_property(node, property, node.get(property))
	_undo.add_undo_property(node, property, restore)
	_undo.add_do_method(node, &"update_gizmos")
	_undo.add_undo_method(node, &"update_gizmos")
	_undo.commit_action()


## Pixels from one corner of a node's box to the opposite one in a camera's picture, however it is turned. As
## [code]volume_handles.gdshader[/code] has it.
static func diagonal_on_screen(node: LumivoxVolume3D, camera: Camera3D) -> float:
	var box := node.get_local_box()
	var view := camera.get_camera_transform().affine_inverse() * node.global_transform
	var center := view * box.get_center()
	var projection := camera.get_camera_projection()
	var w := (projection * Vector4(center.x, center.y, center.z, 1.0)).w
	var height := camera.get_viewport().get_visible_rect().size.y
	return (view.basis * box.size).length() * projection.y.y * height / (2.0 * maxf(w, 1e-6))


func _handle_material(box: AABB) -> ShaderMaterial:
	var icon := EditorInterface.get_editor_theme().get_icon(&"EditorHandle", &"EditorIcons")
	var material := ShaderMaterial.new()
	material.shader = _handle_shader
	material.render_priority = Material.RENDER_PRIORITY_MAX
	material.set_shader_parameter(&"icon", icon)
	material.set_shader_parameter(&"most", float(icon.get_width()))
	material.set_shader_parameter(&"center", box.get_center())
	material.set_shader_parameter(&"extent", box.size)
	material.set_shader_parameter(&"part", HANDLE_PART)
	material.set_shader_parameter(&"least_diagonal", LEAST_DIAGONAL)
	return material


## In clip coordinates, 0 to 1.
func _clip_box(node: LumivoxVolume3D) -> AABB:
	return AABB(node.clip_min, node.clip_max - node.clip_min)


func _face_center(box: AABB, face: int) -> Vector3:
	var center := box.get_center()
	center[face >> 1] = box.end[face >> 1] if face % 2 == 1 else box.position[face >> 1]
	return center


func _edges(box: AABB) -> PackedVector3Array:
	var lines := PackedVector3Array()
	for a in 8:
		for axis: int in [1, 2, 4]:
			if a & axis == 0:
				lines.append(_corner(box, a))
				lines.append(_corner(box, a | axis))
	return lines


func _corner(box: AABB, bits: int) -> Vector3:
	return box.position + box.size * Vector3(bits & 1, (bits >> 1) & 1, (bits >> 2) & 1)


## A letter in front of a face, upright where the face stands, and a tick from the face towards it.
func _add_letter(gizmo: EditorNode3DGizmo, box: AABB, letter: String) -> void:
	var outward := LETTERS[letter]
	var axis := outward.abs().max_axis_index()
	var height := box.size.length() * 0.035
	var up := Vector3.FORWARD if axis == 1 else Vector3.UP
	if letter == "F":
		up = Vector3.BACK
	var across := up.cross(outward)
	var foot := box.get_center() + outward * (box.size[axis] / 2.0)
	var center := foot + outward * height * 0.9
	var lines := PackedVector3Array([foot, foot + outward * height * 0.6])
	for point in STROKES[letter]:
		lines.append(center + (across * (point.x - 0.3) + up * (point.y - 0.5)) * height)
	gizmo.add_lines(lines, get_material(["x", "y", "z"][axis] as String, gizmo))
