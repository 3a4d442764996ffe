@tool
extends EditorNode3DGizmoPlugin
## The shape that cuts a volume, and an arrow towards what is kept.

const SEGMENTS := 48
## Half the side of the square that stands for a plane without end, where there is no volume to tell its size.
const PLANE_HALF := 0.15


func _init() -> void:
	create_material("shape", Color(0.98, 0.82, 0.32))
	create_material("kept", Color(0.55, 0.84, 0.20))
	create_material("face", Color(0.98, 0.82, 0.32, 0.10))


func _get_gizmo_name() -> String:
	return "LumivoxClip3D"


func _has_gizmo(node: Node3D) -> bool:
	return node is LumivoxClip3D


func _redraw(gizmo: EditorNode3DGizmo) -> void:
	gizmo.clear()
	var node := gizmo.get_node_3d() as LumivoxClip3D
	var lines := lines_of(node)
	gizmo.add_lines(lines.shape, get_material("shape", gizmo))
	gizmo.add_lines(lines.kept, get_material("kept", gizmo))
	gizmo.add_collision_segments(lines.shape)
	if node.shape == LumivoxClip3D.SHAPE_PLANE:
		# A sheet to see and to click at: lines alone are hard to find.
		var sheet := PlaneMesh.new()
		sheet.size = Vector2.ONE * 2.0 * plane_half(node)
		gizmo.add_mesh(sheet, get_material("face", gizmo))
		gizmo.add_collision_triangles(sheet.generate_triangle_mesh())


## Pairs of points in the node's space: of the shape, and of the arrow towards what is kept.
static func lines_of(node: LumivoxClip3D) -> Dictionary[String, PackedVector3Array]:
	var shape := PackedVector3Array()
	var from := Vector3.ZERO
	var along := Vector3.UP
	match node.shape:
		LumivoxClip3D.SHAPE_PLANE:
			var half := plane_half(node)
			var corners: Array[Vector3] = [
				Vector3(-half, 0, -half), Vector3(half, 0, -half), Vector3(half, 0, half), Vector3(-half, 0, half)]
			for i in 4:
				shape.append_array([corners[i], corners[(i + 1) % 4]])
			along *= half * 0.5
		LumivoxClip3D.SHAPE_BOX:
			var box := AABB(-Vector3.ONE / 2.0, Vector3.ONE)
			for i in 8:
				for j in [1, 2, 4]:
					if i & j == 0:
						shape.append_array([box.get_endpoint(i), box.get_endpoint(i | j)])
			from = Vector3.UP * 0.5
			along *= -0.2
		LumivoxClip3D.SHAPE_SPHERE:
			for axis in 3:
				for i in SEGMENTS:
					for end in 2:
						var angle := TAU * (i + end) / SEGMENTS
						var point := Vector3.ZERO
						point[(axis + 1) % 3] = 0.5 * cos(angle)
						point[(axis + 2) % 3] = 0.5 * sin(angle)
						shape.append(point)
			from = Vector3.UP * 0.5
			along *= -0.2
	if node.inverted:
		along = -along
	var tip := from + along
	var barb := along * 0.25
	var side := Vector3.RIGHT * barb.length() * 0.6
	return {"shape": shape, "kept": PackedVector3Array([from, tip, tip, tip - barb + side, tip, tip - barb - side])}


## Half the side of the square that stands for a plane: it reaches across the volume, whatever the node's scale.
static func plane_half(node: LumivoxClip3D) -> float:
	var volume := node.get_parent() as LumivoxVolume3D
	var size := volume.get_local_box().size if volume != null else Vector3.ZERO
	if size == Vector3.ZERO:
		return PLANE_HALF
	var scale := node.transform.basis.get_scale().abs()
	return 0.6 * size[size.max_axis_index()] / maxf(maxf(scale.x, scale.z), 1e-4)
