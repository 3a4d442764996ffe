extends Node
## A new compositor and LumivoxEffect in each frame: the ones before are freed while a render thread of its own may be
## drawing with them.

const Shower := preload("res://tests/show_cases.gd")
const FRAMES := 300


func _ready() -> void:
	var arguments := Shower.arguments_by_name()
	var case: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(arguments["cases"]))
	var viewport := LumivoxCase.viewport(case)
	add_child(viewport)
	var camera: Camera3D = viewport.get_child(0).get_node("Camera")
	for frame in FRAMES:
		var effect := LumivoxEffect.new()
		effect.target_samples = 1 + frame % 4
		var effects: Array[CompositorEffect] = [effect]
		camera.compositor = Compositor.new()
		camera.compositor.compositor_effects = effects
		await get_tree().process_frame
	print("TELL swapped %d" % FRAMES)
	camera.compositor = null
	if not await Shower.until_converged(viewport):
		push_error("does not converge: %s" % Lumivox.get_status(viewport))
	LumivoxCase.save(viewport, arguments["out"].path_join("swapped"))
	get_tree().quit()
