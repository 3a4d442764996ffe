extends Node
## Opens scene files and saves what is seen as scene files, and tells of it in lines `TELL name JSON`.

const Shower := preload("res://tests/show_cases.gd")
const PATIENCE_MS := 240_000

## What an importer has said, in order.
var _heard: Array = []
var _out := ""


func _ready() -> void:
	var arguments := Shower.arguments_by_name()
	var all: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(arguments["cases"]))
	_out = arguments["out"]
	var opened := await _open(all)
	await _keep(opened, all.size)
	await _import(all.size)
	# Instances share what they are made of, and what is changed in one.
	await _edit(opened, all.size)
	await _show(all.case)
	await _pass_on(all.hosts_folder, all.hosts, all.hosts_size)
	await _fail(all)
	get_tree().quit()


func _tell(name: String, what: Variant) -> void:
	print("TELL %s %s" % [name, JSON.stringify(what)])


func _listened() -> LumivoxImporter:
	_heard.clear()
	var importer := LumivoxImporter.new()
	importer.progress.connect(func(stage: String, _done: int, _total: int) -> void: _heard.append(["progress", stage]))
	importer.scene_opened.connect(func(scene: PackedScene, notes: PackedStringArray) -> void:
		_heard.append(["opened", scene, notes]))
	importer.failed.connect(func(message: String) -> void: _heard.append(["failed", message]))
	importer.cancelled.connect(func() -> void: _heard.append(["cancelled"]))
	return importer


func _until_ended() -> Array:
	var begin := Time.get_ticks_msec()
	while Time.get_ticks_msec() - begin < PATIENCE_MS:
		if not _heard.is_empty() and _heard[-1][0] != "progress":
			return _heard[-1]
		await get_tree().process_frame
	push_error("the scene is never opened")
	return ["nothing"]


## A viewport of its own world with a scene in it, once its volumes are seen as they will be.
func _viewport(scene: Node, size: Array) -> SubViewport:
	var viewport := SubViewport.new()
	viewport.own_world_3d = true
	viewport.size = Vector2i(int(size[0]), int(size[1]))
	viewport.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	viewport.add_child(scene)
	for world: WorldEnvironment in scene.find_children("*", "WorldEnvironment"):
		# What is saved does not depend on it, and it would take most of the time.
		if world.compositor != null:
			for effect: LumivoxEffect in world.compositor.compositor_effects:
				effect.kept_light = false
	add_child(viewport)
	var begin := Time.get_ticks_msec()
	var frame := 0
	while Time.get_ticks_msec() - begin < PATIENCE_MS:
		frame += 1
		await RenderingServer.frame_post_draw
		var is_preparing := false
		for node in scene.find_children("*", "LumivoxVolume3D"):
			is_preparing = is_preparing or (node as LumivoxVolume3D).is_preparing()
		if frame > 2 and not is_preparing and not Lumivox.get_status(viewport).is_empty():
			return viewport
	push_error("the scene is never seen")
	return viewport


func _save(viewport: Viewport, name: String) -> String:
	return Lumivox.save_scene(viewport, _out.path_join(name + ".lumivox"))


## In the background, into the running game, and saved again from there.
func _open(all: Dictionary) -> PackedScene:
	var importer := _listened()
	var error := importer.open_scene(all.scene)
	var busy := importer.open_scene(all.scene)
	var children := get_child_count()
	var ended := await _until_ended()
	var scene := ended[1] as PackedScene
	var root := scene.instantiate()
	var viewport := await _viewport(root, all.size)
	_tell("opened", {
		"error": error, "busy": busy, "progress": _heard.size() - 1, "notes": ended[2], "added": get_child_count() - children,
		"name": root.name, "saved": _save(viewport, "saved"),
		"nodes": root.find_children("*", "", true, true).map(func(node: Node) -> String: return node.get_class()),
		"exposure": (root.get_node("Environment") as WorldEnvironment).environment.tonemap_exposure,
	})
	viewport.queue_free()
	return scene


## What is changed in the engine is what is saved.
func _edit(scene: PackedScene, size: Array) -> void:
	var root := scene.instantiate()
	var volumes := root.find_children("*", "LumivoxVolume3D")
	var first := volumes[0] as LumivoxVolume3D
	first.position.x += 0.25
	first.density = 0.5
	first.transfer_function.shift = 10.0
	first.labels.set_label("body", "opacity", 0.25)
	first.labels.set_label("body", "surface_roughness", 0.5)
	first.labels.set_label("air outside", "own_surface", true)
	(volumes[1] as LumivoxVolume3D).clip_min = Vector3(0.25, 0, 0)
	(root.find_children("*", "OmniLight3D")[0] as Light3D).light_energy = 1.0
	(root.get_node("Camera") as Camera3D).fov = 50.0
	var world := root.get_node("Environment") as WorldEnvironment
	world.environment.sky_rotation.y = 0.5
	var effect := world.compositor.compositor_effects[0] as LumivoxEffect
	effect.target_samples = 20
	effect.exposure = 0.5
	var viewport := await _viewport(root, size)
	_tell("edited", {"saved": _save(viewport, "edited")})
	viewport.queue_free()


## Through a file of the engine's, with all that is in it.
func _keep(scene: PackedScene, size: Array) -> void:
	var told := {"error": ResourceSaver.save(scene, "user://kept.scn", ResourceSaver.FLAG_COMPRESS)}
	var kept: PackedScene = ResourceLoader.load("user://kept.scn", "", ResourceLoader.CACHE_MODE_IGNORE_DEEP)
	var viewport := await _viewport(kept.instantiate(), size)
	told.saved = _save(viewport, "kept")
	_tell("kept", told)
	viewport.queue_free()


## What the editor's import made of the project's files.
func _import(size: Array) -> void:
	var scan := load("res://scans/head/CT0001.dcm") as LumivoxVolume
	var told := {"files": scan.get_source_files()}
	var root := (load("res://scenes/both.lumivox") as PackedScene).instantiate()
	var viewport := await _viewport(root, size)
	told.saved = _save(viewport, "imported")
	# An imported scan, whose file is told, and one that is told no more.
	var node := root.find_children("*", "LumivoxVolume3D")[0] as LumivoxVolume3D
	(root.find_children("*", "LumivoxVolume3D")[1] as Node3D).visible = false
	node.volume = scan
	await RenderingServer.frame_post_draw
	told.with_scan = _save(viewport, "with_scan")
	scan.forget_source()
	told.forgotten = [_save(viewport, "forgotten"), scan.get_source_files()]
	_tell("imported", told)
	viewport.queue_free()


## A scene that was built here: its picture, and its file.
func _show(case: Dictionary) -> void:
	var viewport := LumivoxCase.viewport(case)
	add_child(viewport)
	var converged := await Shower.until_converged(viewport)
	LumivoxCase.save(viewport, _out.path_join("built"))
	_tell("built", {"converged": converged, "saved": _save(viewport, "built")})
	viewport.queue_free()


## What other hosts saved, saved here; and a scene of the engine's own, for them.
func _pass_on(folder: String, hosts: Array, size: Array) -> void:
	var told := {}
	for host: String in hosts:
		var scene := Lumivox.load_scene(folder.path_join(host + ".lumivox"))
		var viewport := await _viewport(scene.instantiate(), size)
		told[host] = Lumivox.save_scene(viewport, folder.path_join("of-%s.lumivox" % host))
		viewport.queue_free()
	var root := Lumivox.load_scene(folder.path_join("command.lumivox")).instantiate()
	var volume := root.find_children("*", "LumivoxVolume3D")[0] as LumivoxVolume3D
	volume.position.x += 0.03
	volume.rotate_y(0.3)
	volume.density = 0.7
	var lamp := OmniLight3D.new()
	lamp.position = Vector3(0.3, 0.2, 0.4)
	lamp.light_energy = 0.3
	root.add_child(lamp)
	(root.get_node("Camera") as Camera3D).fov = 31.0
	var viewport := await _viewport(root, size)
	told.own = Lumivox.save_scene(viewport, folder.path_join("own.lumivox"))
	viewport.queue_free()
	_tell("passed_on", told)


func _fail(all: Dictionary) -> void:
	var told := {}
	for name: String in all.faulty:
		var importer := _listened()
		importer.open_scene(all.faulty[name])
		told[name] = await _until_ended()
	var importer := _listened()
	importer.open_scene(all.scene)
	importer.cancel()
	told.cancelled = await _until_ended()
	print("EXPECT an error of a scene that is not there")
	told.blocking = Lumivox.load_scene(_out.path_join("nowhere.lumivox"))
	told.no_viewport = Lumivox.save_scene(null, "user://view.lumivox")
	var empty := SubViewport.new()
	add_child(empty)
	told.empty = Lumivox.save_scene(empty, "user://view.lumivox")
	empty.queue_free()
	var root := Node3D.new()
	var node := LumivoxVolume3D.new()
	node.name = "Made"
	node.volume = LumivoxVolume.phantom("cube", 16)
	var camera := Camera3D.new()
	camera.position.z = 0.1
	root.add_child(node)
	root.add_child(camera)
	var viewport := await _viewport(root, all.size)
	told.made = _save(viewport, "saved")
	camera.projection = Camera3D.PROJECTION_ORTHOGONAL
	told.parallel = _save(viewport, "parallel")
	camera.projection = Camera3D.PROJECTION_PERSPECTIVE
	node.volume = LumivoxVolume.load_file("res://scans/head")
	await RenderingServer.frame_post_draw
	told.nowhere = Lumivox.save_scene(viewport, _out.path_join("none/view.lumivox"))
	_tell("faults", told)
	viewport.queue_free()
