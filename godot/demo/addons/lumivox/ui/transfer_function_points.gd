extends RefCounted
## The points of a transfer function as one value, and the edits that people make to them.
##
## A [LumivoxTransferFunction] is read with [method read] and written back with [method write], which changes only what
## differs, so that one edit is one signal. [method state] and [method restore] are what undo keeps.

## Distance that stays between a dragged point and its neighbours, as a fraction of the value range.
const MIN_GAP := 1e-4
## Narrowest and widest window, as [member LumivoxTransferFunction.window_scale] has them.
const WINDOW_SCALES: Array[float] = [0.01, 100.0]

## Opacity knots by rising value: x is the physical value, y the opacity from 0 to 1.
var knots := PackedVector2Array()
## How the segment that starts at each knot runs: 0 straight, 1 slow at both ends.
var eases := PackedByteArray()
## Physical values of the colour stops, rising.
var color_values := PackedFloat32Array()
## Colours of the stops.
var colors := PackedColorArray()
## How steeply values change where each of [member gradient_functions] holds.
var gradients_per_mm := PackedFloat32Array()
## Functions of steeper places, which are not edited here, and not lost.
var gradient_functions: Array[LumivoxTransferFunction] = []
## Moves all values, in the volume's unit.
var shift := 0.0
## Stretches all values about the middle of the points.
var window_scale := 1.0


## Takes over what [param source] holds.
func read(source: LumivoxTransferFunction) -> void:
	knots = source.opacity_knots
	eases = source.opacity_eases
	eases.resize(knots.size())
	color_values = source.color_values
	colors = source.colors
	# Scripts set one after the other. Without colours everything is white.
	var stops := mini(color_values.size(), colors.size())
	color_values.resize(stops)
	colors.resize(stops)
	if stops == 0 and not knots.is_empty():
		add_stop(knots[0].x, Color.WHITE)
	gradients_per_mm = source.gradients_per_mm
	gradient_functions = source.gradient_functions.duplicate()
	shift = source.shift
	window_scale = source.window_scale


## Writes what differs to [param target].
func write(target: LumivoxTransferFunction) -> void:
	if target.opacity_knots != knots or target.opacity_eases != eases \
			or target.color_values != color_values or target.colors != colors:
		target.set_points(knots, eases, color_values, colors)
	if target.gradients_per_mm != gradients_per_mm:
		target.gradients_per_mm = gradients_per_mm
	if target.gradient_functions != gradient_functions:
		target.gradient_functions = gradient_functions.duplicate()
	if target.shift != shift:
		target.shift = shift
	if target.window_scale != window_scale:
		target.window_scale = window_scale


## Everything as plain data.
func state() -> Dictionary:
	return {
		"opacity_knots": knots.duplicate(), "opacity_eases": eases.duplicate(),
		"color_values": color_values.duplicate(), "colors": colors.duplicate(),
		"gradients_per_mm": gradients_per_mm.duplicate(), "gradient_functions": gradient_functions.duplicate(),
		"shift": shift, "window_scale": window_scale,
	}


## Gives [param target] the points of a [method state].
static func restore(target: LumivoxTransferFunction, saved: Dictionary) -> void:
	target.set_points(saved.opacity_knots, saved.opacity_eases, saved.color_values, saved.colors)
	if target.gradients_per_mm != saved.gradients_per_mm:
		target.gradients_per_mm = saved.gradients_per_mm
	if target.gradient_functions != saved.gradient_functions:
		target.gradient_functions = saved.gradient_functions
	target.shift = saved.shift
	target.window_scale = saved.window_scale


## Whether there is anything to show.
func is_empty() -> bool:
	return knots.is_empty() or color_values.is_empty()


## Smallest and largest value of any point, before the window.
func stored_range() -> Vector2:
	if is_empty():
		return Vector2(0.0, 1.0)
	return Vector2(minf(knots[0].x, color_values[0]), maxf(knots[-1].x, color_values[-1]))


## Smallest and largest value of any point as the renderer sees them.
func value_range() -> Vector2:
	var stored := stored_range()
	return Vector2(shown(stored.x), shown(stored.y))


## Where the window puts a stored value.
func shown(value: float) -> float:
	var stored := stored_range()
	var middle := (stored.x + stored.y) / 2.0
	return middle + (value - middle) * window_scale + shift


## Writes the window into the points; nothing looks different. Points are edited as they are shown.
func bake_window() -> void:
	if shift == 0.0 and window_scale == 1.0:
		return
	var moved_knots := PackedVector2Array()
	for knot in knots:
		moved_knots.append(Vector2(shown(knot.x), knot.y))
	var moved_values := PackedFloat32Array()
	for value in color_values:
		moved_values.append(shown(value))
	knots = moved_knots
	color_values = moved_values
	shift = 0.0
	window_scale = 1.0


## Sets the window so that the points' middle and extent come to lie at [param middle] and [param width].
func set_window(middle: float, width: float) -> void:
	var stored := stored_range()
	var extent := stored.y - stored.x
	shift = middle - (stored.x + stored.y) / 2.0
	window_scale = clampf(width / extent, WINDOW_SCALES[0], WINDOW_SCALES[1]) if extent > 0.0 else 1.0


## Moves a knot, between its neighbours.
func move_knot(index: int, to: Vector2) -> void:
	var gap := _gap()
	var low := knots[index - 1].x + gap if index > 0 else -INF
	var high := knots[index + 1].x - gap if index + 1 < knots.size() else INF
	knots[index] = Vector2(_between(to.x, low, high), clampf(to.y, 0.0, 1.0))


## Adds a knot and returns its index. It takes over the ease of the segment that it parts.
func add_knot(at: Vector2) -> int:
	var index := 0
	while index < knots.size() and knots[index].x <= at.x:
		index += 1
	knots.insert(index, Vector2(at.x, clampf(at.y, 0.0, 1.0)))
	eases.insert(index, eases[maxi(index - 1, 0)] if not eases.is_empty() else 0)
	return index


## Removes a knot, unless it is the last. Returns whether it did.
func remove_knot(index: int) -> bool:
	if knots.size() <= 1:
		return false
	knots.remove_at(index)
	eases.remove_at(index)
	return true


## The segment that holds [param value]: the index of the knot it starts at, or -1 outside.
func segment_at(value: float) -> int:
	for i in range(knots.size() - 1):
		if value >= knots[i].x and value < knots[i + 1].x:
			return i
	return -1


## Moves a colour stop, between its neighbours.
func move_stop(index: int, value: float) -> void:
	var gap := _gap()
	var low := color_values[index - 1] + gap if index > 0 else -INF
	var high := color_values[index + 1] - gap if index + 1 < color_values.size() else INF
	color_values[index] = _between(value, low, high)


## Adds a colour stop and returns its index.
func add_stop(value: float, color: Color) -> int:
	var index := 0
	while index < color_values.size() and color_values[index] <= value:
		index += 1
	color_values.insert(index, value)
	colors.insert(index, color)
	return index


## Removes a colour stop, unless it is the last. Returns whether it did.
func remove_stop(index: int) -> bool:
	if color_values.size() <= 1:
		return false
	color_values.remove_at(index)
	colors.remove_at(index)
	return true


func _gap() -> float:
	var stored := stored_range()
	return (stored.y - stored.x) * MIN_GAP


## Points that were loaded may lie closer than the gap.
func _between(value: float, low: float, high: float) -> float:
	return clampf(value, low, high) if low <= high else (low + high) / 2.0
