extends RefCounted
## The horizontal axis that the strips of the transfer-function editor share: physical values over pixels.

## Emitted when another part of the values is shown.
signal view_changed

## Zooming in stops at this part of the full range.
const MAX_ZOOM := 500.0

## All that can be shown: the volume's and the points' values.
var full := Vector2(0.0, 1.0)
## What is shown now.
var view := Vector2(0.0, 1.0)
## The values' unit, such as HU; may be empty.
var unit := ""


## Shows all values.
func fit() -> void:
	show_range(full)


## Sets what can be shown; keeps the view where it still makes sense.
func set_full(low: float, high: float) -> void:
	var wanted := Vector2(low, high) if high > low else Vector2(low - 0.5, low + 0.5)
	if wanted == full:
		return
	var showed_all := view == full
	full = wanted
	if showed_all or view.y < full.x or view.x > full.y:
		fit()


## Shows [param wanted], within limits.
func show_range(wanted: Vector2) -> void:
	var extent := full.y - full.x
	var width := clampf(wanted.y - wanted.x, extent / MAX_ZOOM, extent * 2.0)
	var middle := clampf((wanted.x + wanted.y) / 2.0, full.x, full.y)
	var next := Vector2(middle - width / 2.0, middle + width / 2.0)
	if next != view:
		view = next
		view_changed.emit()


## Zooms by [param factor], keeping [param value] in its place.
func zoom(factor: float, value: float) -> void:
	show_range(Vector2(value + (view.x - value) / factor, value + (view.y - value) / factor))


## Moves the view by values.
func pan(by: float) -> void:
	show_range(Vector2(view.x + by, view.y + by))


## The pixel of a value in a control of that width with margins at both sides.
func x_from_value(value: float, width: float, margin: float) -> float:
	return margin + (value - view.x) / (view.y - view.x) * (width - 2.0 * margin)


## The value at a pixel.
func value_from_x(x: float, width: float, margin: float) -> float:
	return view.x + (x - margin) / maxf(width - 2.0 * margin, 1.0) * (view.y - view.x)


## Round values for ticks, at most about [param count].
func ticks(count: int) -> PackedFloat32Array:
	var rough := (view.y - view.x) / maxf(count, 1.0)
	var decade := pow(10.0, floorf(log(rough) / log(10.0)))
	var step := decade * 10.0
	for factor: float in [1.0, 2.0, 5.0]:
		if decade * factor >= rough:
			step = decade * factor
			break
	var result := PackedFloat32Array()
	var index := ceili(view.x / step)
	while index * step <= view.y:
		result.append(index * step)
		index += 1
	return result


## A value as people read it, with as many decimals as the view needs.
func text(value: float, with_unit := true) -> String:
	var extent := view.y - view.x
	var decimals := clampi(ceili(2.0 - log(extent) / log(10.0)), 0, 6)
	var number := String.num(snappedf(value, pow(10.0, -decimals)), decimals).trim_suffix(".0")
	number = number.replace("-", "−")
	return "%s %s" % [number, unit] if with_unit and unit != "" else number
