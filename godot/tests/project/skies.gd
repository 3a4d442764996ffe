extends Node
## Changes skies while volumes are shown, and tells in lines `TELL name JSON` what the middle of the picture is in each
## frame, and in that of a scene made so.

const Shower := preload("res://tests/show_cases.gd")
const COLORS: Array[Color] = [
	Color(0.2, 0.6, 0.6), Color(0.7, 0.35, 0.7), Color(0.35, 0.7, 0.2), Color(0.9, 0.2, 0.3), Color(0.15, 0.5, 0.9),
]
## More than there are between two looks at what a sky is made of, twice.
const FRAMES := 24

var _case := {}


func _ready() -> void:
	_case = JSON.parse_string(FileAccess.get_file_as_string(Shower.arguments_by_name()["cases"]))
	var viewport := await _shown(_sky(COLORS[0]))
	var world := _world(viewport)
	var before := _middle(viewport)
	world.environment = _sky(COLORS[1])
	before = await _follow("new sky", viewport, before, COLORS[1])
	_paint(world.environment.sky.sky_material, COLORS[2])
	before = await _follow("new properties", viewport, before, COLORS[2])
	world.environment.sky.sky_material = _material(COLORS[3])
	world.environment.background_energy_multiplier = 0.4
	before = await _follow("new material and energy", viewport, before, COLORS[3], 0.4)
	world.environment = _sky(COLORS[4])
	(viewport.get_child(0).get_node("Camera") as Camera3D).cull_mask = 1 | 1 << 4
	(viewport.get_child(0).get_node("volumes0") as LumivoxVolume3D).layers = 1 | 1 << 4
	before = await _follow("new sky and layers", viewport, before, COLORS[4])
	await _fade(viewport, before)
	await _share(viewport)
	get_tree().quit()


## A sky that changes in every frame.
func _fade(viewport: SubViewport, before: Array) -> void:
	var material: ProceduralSkyMaterial = _world(viewport).environment.sky.sky_material
	var frames := []
	for frame in FRAMES:
		_paint(material, COLORS[4].lerp(COLORS[1], (frame + 1.0) / FRAMES))
		await RenderingServer.frame_post_draw
		frames.append(_middle(viewport))
	await _follow("fade", viewport, before, COLORS[1], 1.0, frames)


## Another viewport of the same world, whose camera has skies of its own.
func _share(viewport: SubViewport) -> void:
	var second := LumivoxCase.empty_viewport(_case)
	second.world_3d = viewport.find_world_3d()
	var camera := LumivoxCase.camera(_case)
	camera.environment = _sky(COLORS[2])
	second.add_child(camera)
	add_child(second)
	await Shower.until_converged(second)
	var before := _middle(second)
	var others := _middle(viewport)
	camera.environment = _sky(COLORS[1])
	await _follow("shared world", second, before, COLORS[1])
	_tell("neighbour", others, [_middle(viewport)], others)


func _follow(
		name: String, viewport: SubViewport, before: Array, color: Color, energy: float = 1.0,
		frames: Array = []) -> Array:
	for frame in FRAMES:
		await RenderingServer.frame_post_draw
		frames.append(_middle(viewport))
	await Shower.until_converged(viewport)
	frames.append(_middle(viewport))
	var sky := _sky(color)
	sky.background_energy_multiplier = energy
	var fresh := await _shown(sky)
	_tell(name, before, frames, _middle(fresh))
	fresh.queue_free()
	await get_tree().process_frame
	return frames.back()


func _shown(environment: Environment) -> SubViewport:
	var viewport := LumivoxCase.viewport(_case)
	_world(viewport).environment = environment
	add_child(viewport)
	for frame in FRAMES:
		await RenderingServer.frame_post_draw
	await Shower.until_converged(viewport)
	return viewport


func _tell(name: String, before: Array, frames: Array, fresh: Array) -> void:
	print("TELL %s %s" % [name.replace(" ", "_"), JSON.stringify({
		"before": before, "frames": frames, "fresh": fresh})])


static func _world(viewport: SubViewport) -> WorldEnvironment:
	return viewport.get_child(0).get_node("World")


static func _middle(viewport: Viewport) -> Array:
	var image := viewport.get_texture().get_image()
	var sum := Color(0, 0, 0)
	var side := 8
	for y in side:
		for x in side:
			sum += image.get_pixel((image.get_width() - side) / 2 + x, (image.get_height() - side) / 2 + y)
	return [sum.r, sum.g, sum.b].map(func(c: float) -> float: return c / (side * side))


static func _sky(color: Color) -> Environment:
	var environment := Environment.new()
	environment.background_mode = Environment.BG_SKY
	environment.sky = Sky.new()
	environment.sky.radiance_size = Sky.RADIANCE_SIZE_32
	environment.sky.sky_material = _material(color)
	return environment


static func _material(color: Color) -> ProceduralSkyMaterial:
	var material := ProceduralSkyMaterial.new()
	_paint(material, color)
	return material


static func _paint(material: ProceduralSkyMaterial, color: Color) -> void:
	for part: String in ["sky_top_color", "sky_horizon_color", "ground_bottom_color", "ground_horizon_color"]:
		material.set(part, color)
