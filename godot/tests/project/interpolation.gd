extends Node
## What physics moves twice a second, and the engine shows in between: a mesh and a volume with the same parent, then a
## light. Tells where each frame shows them, in lines `TELL name JSON`.

const Shower := preload("res://tests/show_cases.gd")
const FRAMES := 36
## Metres to either side.
const REACH := 0.012

var _moved: Node3D
var _side := 1.0


func _ready() -> void:
	var arguments := Shower.arguments_by_name()
	var cases: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(arguments["cases"]))
	Engine.physics_ticks_per_second = 2
	get_tree().physics_interpolation = true
	await _watch(cases.together, ["volumes0", "meshes0"], func(image: Image) -> Array:
		return [_center(image, _redness), _center(image, _greenness)])
	await _watch(cases.lamp, ["lamps0"], func(image: Image) -> Array:
		return [_center(image, _brightness)])
	get_tree().quit()


func _physics_process(_delta: float) -> void:
	if _moved != null:
		_side = -_side
		_moved.position.x = REACH * _side


func _watch(case: Dictionary, nodes: Array, measure: Callable) -> void:
	var viewport := LumivoxCase.viewport(case)
	add_child(viewport)
	var root := viewport.get_child(0)
	var parent := Node3D.new()
	root.add_child(parent)
	for node: String in nodes:
		root.get_node(node).reparent(parent)
	await Shower.until_converged(viewport)
	_moved = parent
	var told := []
	# The first ticks only begin the movement.
	var begin := Engine.get_physics_frames() + 2
	# From one side to the other and back, however many frames that takes.
	while len(told) < FRAMES or Engine.get_physics_frames() < begin + 3:
		await RenderingServer.frame_post_draw
		if Engine.get_physics_frames() >= begin:
			var image := viewport.get_texture().get_image()
			told.append([Engine.get_physics_frames()] + measure.call(image))
	_moved = null
	print("TELL %s %s" % [case.name, JSON.stringify(told)])
	viewport.queue_free()
	await get_tree().process_frame


## The mean column of an image's pixels by weight.
static func _center(image: Image, weight: Callable) -> float:
	var sum := 0.0
	var total := 0.0
	for y in image.get_height():
		for x in image.get_width():
			var w: float = weight.call(image.get_pixel(x, y))
			sum += w * x
			total += w
	return sum / total if total > 0.0 else -1.0


static func _redness(pixel: Color) -> float:
	return 1.0 if pixel.r > 1.5 * pixel.g else 0.0


static func _greenness(pixel: Color) -> float:
	return 1.0 if pixel.g > 1.5 * pixel.r else 0.0


static func _brightness(pixel: Color) -> float:
	return pixel.srgb_to_linear().g
