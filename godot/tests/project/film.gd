extends Node
## Shows a volume that turns, in frames that Movie Maker writes, and tells how many samples each frame had.

const Shower := preload("res://tests/show_cases.gd")
const FRAMES := 4


func _ready() -> void:
	var arguments := Shower.arguments_by_name()
	var case: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(arguments["cases"]))
	var scene := LumivoxCase.build(case)
	var world := scene.get_node("World") as WorldEnvironment
	(world.compositor.compositor_effects[0] as LumivoxEffect).target_noise = float(arguments.get("noise", 0.0))
	add_child(scene)
	var samples := []
	for frame in FRAMES:
		await RenderingServer.frame_post_draw
		var status := Lumivox.get_status(get_viewport())
		samples.append(status.get("samples", 0))
		(scene.get_node("volumes0") as Node3D).rotate_y(0.1)
	print("TELL film %s" % JSON.stringify({"samples": samples}))
	get_tree().quit()
