extends Node
## What an exported game can do: import scans that were not there when it was made, and show the demo's main scene.

const PATIENCE_MS := 240_000


func _ready() -> void:
	var arguments := preload("show_cases.gd").arguments_by_name()
	var out: String = arguments["out"]
	tell("game", {
		"plugin": ResourceLoader.exists("res://addons/lumivox/plugin.gd"),
		"dock": ResourceLoader.exists("res://addons/lumivox/editor/transfer_function_dock.gd"),
		"panel": ResourceLoader.exists("res://addons/lumivox/ui/volume_panel.tscn"),
		"project_file": FileAccess.file_exists("res://project.godot"),
		"version": Lumivox.version(),
		"program": OS.get_executable_path(),
	})
	tell("own", own_files())
	tell("import", await import(arguments["scan"]))
	tell("compressed", await preload("codecs.gd").import(arguments["compressed"]))
	var main := (load("res://main.tscn") as PackedScene).instantiate()
	get_tree().root.add_child.call_deferred(main)
	# The head grows first. To finish the picture would take minutes in software.
	var begin := Time.get_ticks_msec()
	while Lumivox.get_status(get_viewport()).is_empty() and Time.get_ticks_msec() - begin < PATIENCE_MS:
		await RenderingServer.frame_post_draw
	for frame in 15:
		await RenderingServer.frame_post_draw
	tell("main", Lumivox.get_status(get_viewport()))
	get_viewport().get_texture().get_image().save_png(out.path_join("main.png"))
	main.queue_free()
	for frame in 3:
		await get_tree().process_frame
	get_tree().quit()


## The bytes of files that are no scans.
func own_files() -> Dictionary:
	var told := {}
	for folder: String in ["own", "left"]:
		told[folder] = {}
		for file: String in ["data.zip", "level.gz", "texture.raw"]:
			var path := "res://".path_join(folder).path_join(file)
			told[folder][file] = Array(FileAccess.get_file_as_bytes(path)) if FileAccess.file_exists(path) else null
	return told


func import(folder: String) -> Dictionary:
	var importer := LumivoxImporter.new()
	var told := {"stages": 0, "done": false}
	importer.progress.connect(func(_stage: String, _done: int, _total: int) -> void: told.stages += 1)
	importer.failed.connect(func(message: String) -> void:
		told.failed = message
		told.done = true)
	importer.finished.connect(func(volume: LumivoxVolume) -> void:
		var dims := volume.get_dimensions()
		told.dims = [dims.x, dims.y, dims.z]
		told.unit = volume.get_unit()
		told.done = true)
	told.started = importer.start([folder])
	var begin := Time.get_ticks_msec()
	while not told.done and Time.get_ticks_msec() - begin < PATIENCE_MS:
		await get_tree().process_frame
	return told


static func tell(name: String, what: Variant) -> void:
	print("TELL %s %s" % [name, JSON.stringify(what, "", true, true)])
