extends HBoxContainer
## A named slider with its value as text.

## Emitted when the slider was moved.
signal value_changed(value: float)

var _slider := HSlider.new()
var _text := Label.new()
var _suffix := ""
var _decimals := 2


## A row for values from [param low] to [param high]; a logarithmic one starts above 0.
func _init(title: String, low: float, high: float, step: float, suffix := "", logarithmic := false) -> void:
	var label := Label.new()
	label.text = title
	label.custom_minimum_size.x = 72.0
	label.modulate.a = 0.8
	add_child(label)
	_suffix = suffix
	_decimals = clampi(ceili(-log(step) / log(10.0) - 1e-6), 0, 4)
	_slider.min_value = low
	_slider.max_value = high
	_slider.step = step
	_slider.exp_edit = logarithmic
	_slider.size_flags_horizontal = Control.SIZE_EXPAND_FILL
	_slider.size_flags_vertical = Control.SIZE_SHRINK_CENTER
	_slider.scrollable = false
	_slider.focus_mode = Control.FOCUS_NONE
	_slider.value_changed.connect(_on_moved)
	add_child(_slider)
	_text.custom_minimum_size.x = 52.0
	_text.horizontal_alignment = HORIZONTAL_ALIGNMENT_RIGHT
	add_child(_text)


## Shows a value without a signal.
func show_value(value: float) -> void:
	_slider.set_value_no_signal(value)
	_show_text(value)


## The value that is shown.
func get_value() -> float:
	return _slider.value


func _on_moved(value: float) -> void:
	_show_text(value)
	value_changed.emit(value)


func _show_text(value: float) -> void:
	_text.text = String.num(value, _decimals).pad_decimals(_decimals) + _suffix
