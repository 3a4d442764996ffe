extends Node
## Saves a picture of the demo and quits: `godot --path godot/demo -- --screenshot PATH [--samples N] [--seconds S]`.
##
## The picture is taken after so many samples per pixel, or so many seconds, whatever comes first.

const ARGUMENT := "--screenshot"

## What can be traced in a frame that nobody waits for.
const BUDGET_MS := 400.0

var path := ""
var samples := 48
var seconds := 150.0


## The node that takes the picture which the command line asks for; null if it asks for none.
static func from_command_line() -> Node:
	var arguments := OS.get_cmdline_user_args()
	var at := arguments.find(ARGUMENT)
	if at < 0 or at + 1 >= arguments.size():
		return null
	var node: Node = (load("res://scenes/demo_screenshot.gd") as GDScript).new()
	node.set(&"path", arguments[at + 1])
	for option: String in ["samples", "seconds"]:
		var place := arguments.find("--" + option)
		if place >= 0 and place + 1 < arguments.size():
			node.set(option, float(arguments[place + 1]))
	return node


func _ready() -> void:
	for layer: Node in get_parent().find_children("*", "CanvasLayer", true, false):
		(layer as CanvasLayer).visible = false
	# Nothing covers the picture now.
	var camera := get_viewport().get_camera_3d() as LumivoxOrbitCamera
	if camera != null:
		camera.covered_right = 0.0
		camera.distance *= 0.82
		camera.jump()
	var worlds := get_parent().find_children("*", "WorldEnvironment", true, false)
	for world: Node in worlds:
		var compositor := (world as WorldEnvironment).compositor
		for effect: CompositorEffect in compositor.compositor_effects if compositor != null else []:
			if effect is LumivoxEffect:
				(effect as LumivoxEffect).frame_budget_ms = BUDGET_MS
	_take.call_deferred()


func _take() -> void:
	var begin := Time.get_ticks_msec()
	var traced := 0
	while Time.get_ticks_msec() - begin < seconds * 1000.0 and traced < samples:
		await RenderingServer.frame_post_draw
		traced = Lumivox.get_status(get_viewport()).get("samples", 0)
	var error := get_viewport().get_texture().get_image().save_png(path)
	if error != OK:
		push_error("%s cannot be written: %s" % [path, error_string(error)])
	print("%s: %d samples per pixel in %.0f s" % [path, traced, (Time.get_ticks_msec() - begin) / 1000.0])
	get_tree().quit(0 if error == OK else 1)
