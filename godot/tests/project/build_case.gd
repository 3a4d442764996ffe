class_name LumivoxCase
## Builds a scene from a description of a test, as `tests/engine/case.rs` writes it.


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


static func build(case: Dictionary) -> Node3D:
	var root := Node3D.new()
	root.name = case.name
	root.add_child(_environment(case))
	root.add_child(_camera(case))
	for volume: Dictionary in case.volumes:
		root.add_child(_volume(volume))
	for mesh: Dictionary in case.meshes:
		root.add_child(_mesh(mesh))
	return root


static func _environment(case: Dictionary) -> WorldEnvironment:
	var environment := Environment.new()
	environment.tonemap_mode = Environment.TONE_MAPPER_LINEAR
	var light: Dictionary = case.light
	if light.has("Color"):
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
	var effect := LumivoxEffect.new()
	effect.target_samples = int(case.samples)
	effect.exposure = case.exposure
	effect.frame_budget_ms = 50.0
	var compositor := Compositor.new()
	compositor.compositor_effects = [effect]
	var world := WorldEnvironment.new()
	world.environment = environment
	world.compositor = compositor
	return world


static func _camera(case: Dictionary) -> Camera3D:
	var camera := Camera3D.new()
	camera.name = "Camera"
	camera.transform = transform(case.camera)
	camera.near = 0.001
	camera.far = 10.0
	if case.fov > 0.0:
		camera.fov = case.fov
	else:
		camera.projection = Camera3D.PROJECTION_ORTHOGONAL
		camera.size = case.height
	camera.current = true
	return camera


static func _volume(description: Dictionary) -> LumivoxVolume3D:
	var function := LumivoxTransferFunction.new()
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
	var node := LumivoxVolume3D.new()
	node.volume = LumivoxVolume.phantom(description.phantom, int(description.size))
	node.transfer_function = function
	node.density = description.density
	node.albedo = description.albedo
	node.anisotropy = description.anisotropy
	node.max_bounces = int(description.max_bounces)
	node.filter = int(description.filter)
	node.surface_strength = description.surface[0]
	node.surface_gradient = description.surface[1]
	node.surface_roughness = description.surface[2]
	node.surface_specular = description.surface[3]
	node.clip_min = vector(description.clip_min)
	node.clip_max = vector(description.clip_max)
	node.transform = transform(description.place)
	return node


static func _mesh(description: Dictionary) -> MeshInstance3D:
	var box := BoxMesh.new()
	box.size = vector(description.size)
	var material := StandardMaterial3D.new()
	material.shading_mode = BaseMaterial3D.SHADING_MODE_UNSHADED
	material.albedo_color = color(description.color)
	box.material = material
	var node := MeshInstance3D.new()
	node.mesh = box
	node.transform = transform(description.place)
	return node
