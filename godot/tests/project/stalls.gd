extends Node
## Changes what volumes want of the GPU, and tells what frames show and wait for meanwhile, in lines `TELL name JSON`.

const Shower := preload("res://tests/show_cases.gd")
const PATIENCE_FRAMES := 3000
const FEATURES := ["surface", "many_volumes"]


func _ready() -> void:
	var arguments := Shower.arguments_by_name()
	var all: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(arguments["cases"]))
	var scenes: Array = all.scenes
	_tell("before", await _change_while_shown(scenes[0]))
	_tell("replaced", await _replace_under_another_light(scenes[0]))
	_tell("once", await _draw_once(scenes[0]))
	_tell("once_under_sky", await _draw_once(scenes[0], _sky()))
	print("EXPECT an error: there is no such feature")
	Lumivox.warm_up(PackedStringArray(["volumes"]))
	_tell("unknown", {"progress": Lumivox.get_warm_up_progress()})
	_tell("warm_up", await _warm_up(scenes))
	Lumivox.warm_up(FEATURES)
	await Lumivox.warmed_up
	_tell("again", {"ended": true})
	get_tree().quit()


func _tell(what: String, told: Variant) -> void:
	print("TELL %s %s" % [what, JSON.stringify(told)])


## Another filter wants another kernel and other value ranges; another environment makes another scene.
func _change_while_shown(case: Dictionary) -> Dictionary:
	var viewport := LumivoxCase.viewport(case)
	add_child(viewport)
	await Shower.until_converged(viewport)
	var node: LumivoxVolume3D = viewport.get_child(0).get_node("volumes0")
	node.filter = LumivoxVolume3D.FILTER_TRICUBIC
	var told := {"filled": await _filled_until_converged(viewport), "stalls": Lumivox._get_stalls()}
	_world(viewport).environment = _sky()
	told.relit = await _filled_until_converged(viewport)
	viewport.queue_free()
	await get_tree().process_frame
	return told


## Megabytes of textures with a scan, and with another in its place once the light has changed as well.
func _replace_under_another_light(case: Dictionary) -> Dictionary:
	var viewport := LumivoxCase.viewport(case)
	add_child(viewport)
	var node: LumivoxVolume3D = viewport.get_child(0).get_node("volumes0")
	await _filled_until_converged(viewport)
	var told := {"before": await _texture_megabytes()}
	node.volume = LumivoxVolume.phantom("cube", 200)
	await _filled_until_converged(viewport)
	told.scan = await _texture_megabytes()
	_world(viewport).environment = _sky()
	await _filled_until_converged(viewport)
	told.relit = await _texture_megabytes()
	node.volume = LumivoxVolume.phantom("cube", 200)
	await _filled_until_converged(viewport)
	told.replaced = await _texture_megabytes()
	viewport.queue_free()
	await get_tree().process_frame
	return told


static func _texture_megabytes() -> float:
	# What is freed is there for some frames more.
	for frame in 8:
		await RenderingServer.frame_post_draw
	return RenderingServer.get_rendering_device().get_memory_usage(RenderingDevice.MEMORY_TEXTURES) * 1e-6


func _draw_once(case: Dictionary, environment: Environment = null) -> Dictionary:
	# Nothing else here has both, so that its kernel is new.
	case = case.duplicate(true)
	case.volumes[0].surface = [0.5, 60.0, 0.4, 0.04, 0.0]
	case.volumes[0].filter = 0.0
	var viewport := LumivoxCase.viewport(case)
	viewport.render_target_update_mode = SubViewport.UPDATE_ONCE
	if environment != null:
		_world(viewport).environment = environment
	add_child(viewport)
	for frame in 4:
		await RenderingServer.frame_post_draw
	var told := {"filled": _filled(viewport), "samples": Lumivox.get_status(viewport).get("samples", 0)}
	viewport.queue_free()
	await get_tree().process_frame
	return told


func _warm_up(scenes: Array) -> Dictionary:
	var begin := Time.get_ticks_msec()
	Lumivox.warm_up(FEATURES)
	await Lumivox.warmed_up
	var progress := Lumivox.get_warm_up_progress()
	print("warm up: %d ms" % (Time.get_ticks_msec() - begin))
	var before := Lumivox._get_stalls()
	var converged := []
	var kept := []
	for case: Dictionary in scenes:
		var viewport := LumivoxCase.viewport(case)
		add_child(viewport)
		converged.append(await Shower.until_converged(viewport))
		# What moves is shown by kept light, whose programs are there, too.
		var effect: LumivoxEffect = _world(viewport).compositor.compositor_effects[0]
		effect.target_samples = 4096
		effect.frame_budget_ms = 1.0
		for frame in 3:
			viewport.get_camera_3d().rotate_y(0.01)
			await RenderingServer.frame_post_draw
		kept.append(Lumivox.get_status(viewport).kept_light_bytes > 0)
		viewport.queue_free()
		await get_tree().process_frame
	var after := Lumivox._get_stalls()
	var stalls := {}
	for name: String in after:
		stalls[name] = after[name] - before[name]
	return {"progress": progress, "stalls": stalls, "converged": converged, "kept": kept}


static func _world(viewport: SubViewport) -> WorldEnvironment:
	return viewport.get_child(0).get_node("World")


## A blue one, that the engine has to draw before its light is known.
static func _sky() -> Environment:
	var material := ProceduralSkyMaterial.new()
	material.ground_bottom_color = Color(0.1, 0.15, 0.3)
	material.ground_horizon_color = Color(0.3, 0.4, 0.6)
	material.sky_horizon_color = Color(0.3, 0.4, 0.6)
	var environment := Environment.new()
	environment.background_mode = Environment.BG_SKY
	environment.sky = Sky.new()
	environment.sky.sky_material = material
	return environment


## The share of red pixels of each frame until the picture is done.
func _filled_until_converged(viewport: Viewport) -> Array[float]:
	var filled: Array[float] = []
	for frame in PATIENCE_FRAMES:
		await RenderingServer.frame_post_draw
		filled.append(_filled(viewport))
		if frame > 1 and Lumivox.is_converged(viewport):
			break
	return filled


## The share of a viewport's pixels that the red volume is in.
static func _filled(viewport: Viewport) -> float:
	var image := viewport.get_texture().get_image()
	var red := 0
	for y in image.get_height():
		for x in image.get_width():
			var pixel := image.get_pixel(x, y)
			if pixel.r > 1.3 * pixel.b:
				red += 1
	return float(red) / (image.get_width() * image.get_height())
