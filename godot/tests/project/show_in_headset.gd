extends Node3D
## Shows cases in a headset until both eyes have converged, and saves what each eye saw and from where.

const PATIENCE_FRAMES := 1500
## Frames that are watched, while the head moves.
const FRAMES := 40

var _arguments := {}
var _interface: OpenXRInterface


func _ready() -> void:
	_arguments = preload("show_cases.gd").arguments_by_name()
	_interface = XRServer.find_interface("OpenXR") as OpenXRInterface
	if _interface == null or not _interface.is_initialized():
		push_error("OpenXR did not start.")
		get_tree().quit(1)
		return
	DisplayServer.window_set_vsync_mode(DisplayServer.VSYNC_DISABLED)
	_interface.render_target_size_multiplier = float(_arguments["scale"] as String)
	get_viewport().use_xr = true
	var cases: Array = JSON.parse_string(FileAccess.get_file_as_string(_arguments["cases"]))
	for case: Dictionary in cases:
		await _show(case)
	get_tree().quit()


func _show(case: Dictionary) -> void:
	var scene := LumivoxCase.build(case)
	var pictures := EyePictures.new()
	var compositor := (scene.get_child(0) as WorldEnvironment).compositor
	compositor.compositor_effects += [pictures] as Array[CompositorEffect]
	var flat := scene.get_node("Camera") as Camera3D
	flat.current = false
	var origin := XROrigin3D.new()
	var camera := XRCamera3D.new()
	camera.near = flat.near
	camera.far = flat.far
	camera.current = true
	origin.add_child(camera)
	scene.add_child(origin)
	add_child(scene)
	# The head is tracked from some frame on; then the room is put so that it stands where the case's camera does.
	for frame in 10:
		await RenderingServer.frame_post_draw
	origin.global_transform = LumivoxCase.transform(case.camera) * XRServer.get_hmd_transform().affine_inverse()
	# Until the scene's programs are made there is nothing to see.
	for frame in PATIENCE_FRAMES:
		await RenderingServer.frame_post_draw
		if Lumivox.get_status(get_viewport()).get("samples", 0) > 0:
			break
	var seen := {"frames": 0, "moved": 0, "unfinished": 0, "views": _interface.get_view_count()}
	var before := _places()
	for frame in PATIENCE_FRAMES:
		await RenderingServer.frame_post_draw
		seen.frames += 1
		seen.moved += int(_places() != before)
		before = _places()
		# Not whether it has converged: in software that is known frames later, of a head that rests.
		var whole: bool = Lumivox.get_status(get_viewport()).get("samples", 0) >= int(case.samples)
		seen.unfinished += int(not whole)
		if frame >= FRAMES and whole:
			break
	seen.status = Lumivox.get_status(get_viewport())
	seen.eyes = []
	var images := pictures.images()
	for view in images.size():
		var path := (_arguments["out"] as String).path_join("%s_%d.f32" % [case.name, view])
		images[view].convert(Image.FORMAT_RGBF)
		FileAccess.open(path, FileAccess.WRITE).store_buffer(images[view].get_data())
		var size := images[view].get_size()
		var projection := _interface.get_projection_for_view(view, float(size.x) / size.y, camera.near, camera.far)
		seen.eyes.append({
			"size": [size.x, size.y],
			"place": _numbers(before[view]),
			"tangents": [
				(projection.z.x - 1.0) / projection.x.x, (projection.z.x + 1.0) / projection.x.x,
				(projection.z.y - 1.0) / projection.y.y, (projection.z.y + 1.0) / projection.y.y],
		})
	var file := FileAccess.open((_arguments["out"] as String).path_join(case.name + ".json"), FileAccess.WRITE)
	file.store_string(JSON.stringify(seen, "\t", false, true))
	file.close()
	compositor.compositor_effects = []
	scene.queue_free()
	await get_tree().process_frame
	pictures.free_all()


## Where the eyes were in the frame that was just drawn.
func _places() -> Array[Transform3D]:
	var places: Array[Transform3D] = []
	for view in _interface.get_view_count():
		places.append(_interface.get_transform_for_view(view, XRServer.world_origin))
	return places


static func _numbers(place: Transform3D) -> Array[float]:
	var numbers: Array[float] = []
	for column: Vector3 in [place.basis.x, place.basis.y, place.basis.z, place.origin]:
		numbers.append_array([column.x, column.y, column.z])
	return numbers
