extends RefCounted
## Small pictures of a volume under a transfer function: a few slices, front to back, with a headlight.
##
## Plain GDScript on purpose: it runs on a worker thread and needs no renderer. For the choice of a preset only.

## Pixels of a picture's side.
const SIZE := 72
## Slices that a picture is composed of.
const SLICES := 56
## Extinction per metre at opacity 1; a picture needs less than the renderer.
const EXTINCTION := 260.0

var _bytes: Array[PackedByteArray] = []
var _window := Vector2.ZERO
var _slice_m := 0.0


## Reads the slices of [param volume] once for all pictures.
func _init(volume: LumivoxVolume) -> void:
	_window = volume.get_value_range()
	var dims := volume.get_dimensions()
	_slice_m = volume.get_size_m().y / SLICES
	# Coronal slices of an axial scan: the rays run from the front to the back.
	for i in SLICES:
		var slice := volume.get_slice(1, mini(int((i + 0.5) / SLICES * dims.y), dims.y - 1), _window)
		if slice == null or slice.is_empty():
			return
		slice.convert(Image.FORMAT_L8)
		slice.resize(SIZE, SIZE, Image.INTERPOLATE_BILINEAR)
		_bytes.append(slice.get_data())


## The picture; null when the volume has no slices to show.
func render(transfer_function: LumivoxTransferFunction) -> Image:
	if _bytes.size() < SLICES:
		return null
	var alphas := PackedFloat32Array()
	var colors := PackedColorArray()
	for level in 256:
		var value := lerpf(_window.x, _window.y, level / 255.0)
		alphas.append(1.0 - exp(-transfer_function.get_opacity(value) * EXTINCTION * _slice_m))
		colors.append(transfer_function.get_color(value))
	var depth := PackedFloat32Array()
	depth.resize(SIZE * SIZE)
	var image := Image.create_empty(SIZE, SIZE, false, Image.FORMAT_RGBA8)
	for pixel in SIZE * SIZE:
		@warning_ignore("integer_division")
		var row := pixel / SIZE
		var color := Color(0.0, 0.0, 0.0, 0.0)
		var reached := float(SLICES)
		for i in SLICES:
			var level := _bytes[i][pixel]
			var alpha := alphas[level] * (1.0 - color.a)
			if alpha <= 0.001:
				continue
			# Between slices: whole numbers would show as terraces.
			if color.a <= 0.5 and color.a + alpha > 0.5:
				reached = i + (0.5 - color.a) / alpha
			color = Color(color + colors[level] * alpha, color.a + alpha)
			if color.a > 0.97:
				break
		depth[pixel] = reached
		image.set_pixel(pixel % SIZE, row, color)
	_shade(image, _blur(depth))
	return image


## The mean of each pixel and its neighbours at about its depth: edges stay.
func _blur(depth: PackedFloat32Array) -> PackedFloat32Array:
	var blurred := depth.duplicate()
	for y in range(1, SIZE - 1):
		for x in range(1, SIZE - 1):
			var pixel := y * SIZE + x
			var total := 0.0
			var count := 0
			for dy: int in [-1, 0, 1]:
				for dx: int in [-1, 0, 1]:
					var near := depth[pixel + dy * SIZE + dx]
					if absf(near - depth[pixel]) < 4.0:
						total += near
						count += 1
			blurred[pixel] = total / count
	return blurred


## A light from the upper left, by the slope of the depth.
func _shade(image: Image, depth: PackedFloat32Array) -> void:
	for y in SIZE:
		for x in SIZE:
			var color := image.get_pixel(x, y)
			if color.a <= 0.01:
				continue
			var right := depth[y * SIZE + mini(x + 1, SIZE - 1)] - depth[y * SIZE + maxi(x - 1, 0)]
			var down := depth[mini(y + 1, SIZE - 1) * SIZE + x] - depth[maxi(y - 1, 0) * SIZE + x]
			var normal := Vector3(right, down, -1.6).normalized()
			var light := clampf(normal.dot(Vector3(-0.45, -0.55, -0.7).normalized()), 0.0, 1.0)
			var lit := color * (0.28 + 0.85 * light)
			image.set_pixel(x, y, Color(lit.r / color.a, lit.g / color.a, lit.b / color.a, color.a).clamp())
