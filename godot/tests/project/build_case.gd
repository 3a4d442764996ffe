class_name LumivoxCase
## Builds a scene from a description of a test, as `tests/engine/case.rs` writes it, and changes it to another.

## Shows its colour where the depth behind it is that of something.
const DEPTH_READER := "shader_type spatial;
render_mode unshaded, fog_disabled;
uniform vec3 color;
uniform sampler2D behind : hint_depth_texture, filter_nearest;
void fragment() {
	ALBEDO = texture(behind, SCREEN_UV).r > 0.0 ? color : vec3(0.0);
}
"

const MSAA := {1: Viewport.MSAA_DISABLED, 2: Viewport.MSAA_2X, 4: Viewport.MSAA_4X, 8: Viewport.MSAA_8X}


static func transform(numbers: Array) -> Transform3D:
	return Transform3D(
		Vector3(numbers[0], numbers[1], numbers[2]),
		Vector3(numbers[3], numbers[4], numbers[5]),
		Vector3(numbers[6], numbers[7], numbers[8]),
		Vector3(numbers[9], numbers[10], numbers[11]))


## A colour of linear components, as Godot's properties take it.
static func color(linear: Array) -> Color:
	return Color(linear[0], linear[1], linear[2]).linear_to_srgb()


static func vector(numbers: Array) -> Vector3:
	return Vector3(numbers[0], numbers[1], numbers[2])


## A viewport of its own world that shows a case.
static func viewport(case: Dictionary) -> SubViewport:
	var shown := empty_viewport(case)
	shown.own_world_3d = true
	shown.add_child(build(case))
	return shown


static func empty_viewport(case: Dictionary) -> SubViewport:
	var shown := SubViewport.new()
	shown.size = Vector2i(int(case.size[0]), int(case.size[1]))
	shown.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	var output: Dictionary = case.output
	shown.msaa_3d = MSAA[int(output.msaa)]
	shown.scaling_3d_scale = output.scale
	shown.scaling_3d_mode = int(output.scaling) as Viewport.Scaling3DMode
	shown.use_hdr_2d = output.hdr
	shown.transparent_bg = output.transparent
	shown.use_taa = output.taa
	return shown


## Saves what a viewport shows as `path.png`, and its alpha as `path_alpha.png` if it has any.
static func save(shown: Viewport, path: String) -> void:
	var image := shown.get_texture().get_image()
	if shown.use_hdr_2d or shown.transparent_bg:
		# What the engine converts, it rounds down.
		var color := Image.create_empty(image.get_width(), image.get_height(), false, Image.FORMAT_RGB8)
		var alpha: Image = color.duplicate()
		for y in image.get_height():
			for x in image.get_width():
				var pixel := image.get_pixel(x, y)
				if shown.use_hdr_2d:
					pixel = pixel.clamp().linear_to_srgb()
				color.set_pixel(x, y, Color8(roundi(pixel.r * 255), roundi(pixel.g * 255), roundi(pixel.b * 255)))
				var a := roundi(pixel.a * 255)
				alpha.set_pixel(x, y, Color8(a, a, a))
		if shown.transparent_bg:
			alpha.save_png(path + "_alpha.png")
		image = color
	image.convert(Image.FORMAT_RGB8)
	image.save_png(path + ".png")


static func build(case: Dictionary) -> Node3D:
	var root := Node3D.new()
	root.name = case.name
	root.add_child(_environment(case))
	root.add_child(camera(case))
	for list: String in [
			"volumes", "meshes", "lit_meshes", "glass", "clear_glass", "depth_readers", "skin", "lamps"]:
		for i in len(case[list]):
			var node := _node(list, case[list][i])
			node.name = "%s%d" % [list, i]
			root.add_child(node)
	return root


## Turns what shows one case into what shows another with as many nodes, and touches nothing but what differs.
static func change(root: Node3D, from: Dictionary, to: Dictionary) -> void:
	var world: WorldEnvironment = root.get_node("World")
	var effect: LumivoxEffect = world.compositor.compositor_effects[0]
	if from.samples != to.samples:
		effect.target_samples = int(to.samples)
	if from.exposure != to.exposure:
		effect.exposure = to.exposure
	if from.budget != to.budget:
		effect.frame_budget_ms = to.budget
	if from.light != to.light:
		world.environment.background_color = color(to.light.Color)
	var node: Camera3D = root.get_node("Camera")
	if from.camera != to.camera:
		node.transform = transform(to.camera)
	if from.fov != to.fov:
		node.fov = to.fov
	for i in len(to.volumes):
		set_volume(root.get_node("volumes%d" % i), to.volumes[i], from.volumes[i])
	for i in len(to.lamps):
		set_lamp(root.get_node("lamps%d" % i), to.lamps[i], from.lamps[i])
	for i in len(to.meshes):
		if from.meshes[i].place != to.meshes[i].place:
			root.get_node("meshes%d" % i).transform = transform(to.meshes[i].place)
	var shown := root.get_viewport() as SubViewport
	if from.size != to.size:
		shown.size = Vector2i(int(to.size[0]), int(to.size[1]))


static func _environment(case: Dictionary) -> WorldEnvironment:
	var environment := Environment.new()
	environment.tonemap_mode = Environment.TONE_MAPPER_LINEAR
	var light: Dictionary = case.light
	if case.output.transparent:
		environment.background_mode = Environment.BG_CLEAR_COLOR
		environment.ambient_light_source = Environment.AMBIENT_SOURCE_COLOR
		environment.ambient_light_color = color(light.Color)
	elif light.has("Color"):
		environment.background_mode = Environment.BG_COLOR
		environment.background_color = color(light.Color)
	else:
		var panorama: Dictionary = light.Panorama
		var bytes := PackedFloat32Array()
		for texel: Array in panorama.texels:
			bytes.append_array(PackedFloat32Array([texel[0], texel[1], texel[2]]))
		var image := Image.create_from_data(
			panorama.width, panorama.height, false, Image.FORMAT_RGBF, bytes.to_byte_array())
		var material := PanoramaSkyMaterial.new()
		material.panorama = ImageTexture.create_from_image(image)
		var sky := Sky.new()
		sky.sky_material = material
		environment.background_mode = Environment.BG_SKY
		environment.sky = sky
		environment.sky_rotation.y = panorama.rotation
		environment.background_energy_multiplier = panorama.energy
	if case.fog != null:
		_set_fog(environment, case.fog)
	var effect := LumivoxEffect.new()
	effect.target_samples = int(case.samples)
	effect.exposure = case.exposure
	effect.frame_budget_ms = case.budget
	effect.kept_light = case.kept_light
	if case.studio:
		effect.environment_source = LumivoxEffect.ENVIRONMENT_STUDIO
	var compositor := Compositor.new()
	compositor.compositor_effects = [effect]
	var world := WorldEnvironment.new()
	world.name = "World"
	world.environment = environment
	world.compositor = compositor
	return world


static func _set_fog(environment: Environment, fog: Dictionary) -> void:
	environment.fog_enabled = true
	if fog.depth != null:
		environment.fog_mode = Environment.FOG_MODE_DEPTH
		environment.fog_depth_end = fog.depth[1]
		environment.fog_depth_begin = fog.depth[0]
		environment.fog_depth_curve = fog.depth[2]
	environment.fog_light_color = color(fog.color)
	environment.fog_light_energy = fog.energy
	environment.fog_density = fog.density
	# Of the background alone.
	environment.fog_sky_affect = 0.0
	environment.fog_height = fog.height
	environment.fog_height_density = fog.height_density


static func camera(case: Dictionary) -> Camera3D:
	var node := Camera3D.new()
	node.name = "Camera"
	node.transform = transform(case.camera)
	node.near = 0.001
	node.far = 10.0
	if case.fov > 0.0:
		node.fov = case.fov
	else:
		node.projection = Camera3D.PROJECTION_ORTHOGONAL
		node.size = case.height
	node.current = true
	return node


static func _node(list: String, description: Dictionary) -> Node3D:
	match list:
		"volumes":
			var node := LumivoxVolume3D.new()
			set_volume(node, description)
			return node
		"lamps":
			return _lamp(description)
		_:
			return _mesh(list, description)


## Gives a volume what `description` says and `known` does not say already.
static func set_volume(node: LumivoxVolume3D, description: Dictionary, known := {}) -> void:
	var differs := func(key: String) -> bool: return known.get(key) != description[key]
	if differs.call("phantom") or differs.call("size"):
		if description.phantom == "table":
			node.volume = LumivoxVolume.load_file(description.series)
		else:
			node.volume = LumivoxVolume.phantom(description.phantom, int(description.size))
	if differs.call("keep_everything"):
		node.keep_everything = description.keep_everything
	if differs.call("preset"):
		# Its organ, not the rest of its look.
		node.set(&"chosen_preset", description.preset)
	if differs.call("knots") or differs.call("stops"):
		if node.transfer_function == null:
			node.transfer_function = LumivoxTransferFunction.new()
		_set_points(node.transfer_function, description)
	if differs.call("function") and description.function != "":
		node.transfer_function = saved_and_loaded(LumivoxTransferFunction.load_file(description.function))
	for property: String in ["density", "albedo", "anisotropy", "visible"]:
		if differs.call(property):
			node.set(property, description[property])
	if differs.call("max_bounces"):
		node.max_bounces = int(description.max_bounces)
	if differs.call("filter"):
		node.filter = int(description.filter)
	if differs.call("surface"):
		node.surface_strength = description.surface[0]
		node.surface_gradient = description.surface[1]
		node.surface_roughness = description.surface[2]
		node.surface_specular = description.surface[3]
		node.surface_metallic = description.surface[4]
	if differs.call("look") and description.look != "":
		node.apply_preset(description.look)
	if differs.call("clip_min"):
		node.clip_min = vector(description.clip_min)
	if differs.call("clip_max"):
		node.clip_max = vector(description.clip_max)
	if differs.call("clips"):
		for clip: Dictionary in description.clips:
			var shape := LumivoxClip3D.new()
			shape.shape = int(clip.shape)
			shape.inverted = clip.inverted
			shape.transform = transform(clip.place)
			node.add_child(shape)
	if differs.call("shown_labels") and not description.shown_labels.is_empty():
		var labels := LumivoxLabels.found_in(node.volume)
		for one: Array in description.shown_labels:
			labels.set("labels/%s/visible" % one[0], one[1])
		node.labels = labels
	if differs.call("layers"):
		node.layers = int(description.layers)
	if differs.call("place"):
		node.transform = transform(description.place)


## A transfer function that went through a resource's file, and through one of Lumivox's.
static func saved_and_loaded(function: LumivoxTransferFunction) -> LumivoxTransferFunction:
	ResourceSaver.save(function, "user://function.tres")
	var loaded: LumivoxTransferFunction = ResourceLoader.load(
			"user://function.tres", "", ResourceLoader.CACHE_MODE_IGNORE_DEEP)
	loaded.save_file("user://function.json")
	return LumivoxTransferFunction.load_file("user://function.json")


static func _set_points(function: LumivoxTransferFunction, description: Dictionary) -> void:
	var knots := PackedVector2Array()
	var eases := PackedByteArray()
	for knot: Array in description.knots:
		knots.append(Vector2(knot[0], knot[1]))
		eases.append(int(knot[2]))
	var values := PackedFloat32Array()
	var colors := PackedColorArray()
	for stop: Array in description.stops:
		values.append(stop[0])
		colors.append(color(stop.slice(1)))
	function.set_points(knots, eases, values, colors)


static func _lamp(description: Dictionary) -> Light3D:
	var node: Light3D
	match description.kind:
		"Directional":
			node = DirectionalLight3D.new()
		"Omni":
			node = OmniLight3D.new()
		"Spot":
			node = SpotLight3D.new()
	set_lamp(node, description)
	return node


static func set_lamp(node: Light3D, description: Dictionary, known := {}) -> void:
	if description == known:
		return
	node.light_color = color(description.color)
	node.light_energy = description.energy
	node.light_cull_mask = int(description.layers)
	node.transform = transform(description.place)
	if node is DirectionalLight3D:
		node.light_angular_distance = description.size
		return
	node.light_size = description.size
	if node is OmniLight3D:
		node.omni_range = description.range
		node.omni_attenuation = description.attenuation
	else:
		node.spot_range = description.range
		node.spot_attenuation = description.attenuation
		node.spot_angle = description.spot_angle
		node.spot_angle_attenuation = description.spot_attenuation


static func _mesh(list: String, description: Dictionary) -> MeshInstance3D:
	var box := BoxMesh.new()
	box.size = vector(description.size)
	var material := StandardMaterial3D.new()
	material.albedo_color = color(description.color)
	match list:
		"meshes":
			material.shading_mode = BaseMaterial3D.SHADING_MODE_UNSHADED
		"lit_meshes":
			material.diffuse_mode = BaseMaterial3D.DIFFUSE_LAMBERT
			material.specular_mode = BaseMaterial3D.SPECULAR_DISABLED
		"glass":
			material.shading_mode = BaseMaterial3D.SHADING_MODE_UNSHADED
			material.transparency = BaseMaterial3D.TRANSPARENCY_ALPHA
			material.albedo_color.a = 0.5
		"clear_glass":
			material.albedo_color = Color.TRANSPARENT
			material.refraction_enabled = true
			material.refraction_scale = 0.0
			material.roughness = 0.0
			material.specular_mode = BaseMaterial3D.SPECULAR_DISABLED
			material.disable_ambient_light = true
		"skin":
			material.subsurf_scatter_enabled = true
			material.subsurf_scatter_strength = 1.0
			material.roughness = 0.3
	box.material = _depth_reader(description.color) if list == "depth_readers" else material
	var node := MeshInstance3D.new()
	node.mesh = box
	node.transform = transform(description.place)
	return node


static func _depth_reader(linear: Array) -> ShaderMaterial:
	var material := ShaderMaterial.new()
	material.shader = Shader.new()
	material.shader.code = DEPTH_READER
	material.set_shader_parameter(&"color", vector(linear))
	return material
