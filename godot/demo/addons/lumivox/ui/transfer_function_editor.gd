@tool
@icon("../icons/lumivox_transfer_function.svg")
class_name LumivoxTransferFunctionEditor
extends VBoxContainer
## Edits a [LumivoxTransferFunction]: opacity over the volume's histogram, colours, window, presets, files.
##
## Works in the editor's dock and in a running game. Set [member transfer_function] and, for histogram and pictures,
## [member volume]. The resource changes while a point is dragged; connect to [signal edit_finished] to keep undo
## steps, and give a step back with [method restore].

## Emitted before the first change of an edit.
signal edit_started
## Emitted after an edit with the points before and after it, for [method restore]. Where [member merges] is on, it may
## go on with the edit before.
signal edit_finished(before: Dictionary, after: Dictionary)
## Emitted when a preset was chosen. When [member apply_presets] is off, applying it is up to the owner.
signal preset_chosen(preset: String)

const Points := preload("transfer_function_points.gd")
const ValueAxis := preload("value_axis.gd")
const ValueStrip := preload("value_strip.gd")
const OpacityGraph := preload("opacity_graph.gd")
const ColorStrip := preload("color_strip.gd")
const WindowStrip := preload("window_strip.gd")
const PresetGallery := preload("preset_gallery.gd")

## Bins of the histogram over what is shown.
const HISTOGRAM_BINS := 384
## Seconds without zooming before the histogram is taken anew.
const HISTOGRAM_DELAY := 0.15
## Opacity is shown to the power of 1 over this when small opacities are emphasised.
const EMPHASIS := 2.5
## Values shown where neither volume nor points say which: those of a CT scanner.
const CT_VALUES := Vector2(-1024.0, 3071.0)

## What is edited.
@export var transfer_function: LumivoxTransferFunction:
	set = set_transfer_function
## The scan whose histogram and pictures are shown; may be null.
@export var volume: LumivoxVolume:
	set = set_volume
## Whether a chosen preset's points are taken over here. Off when a preset is to set a volume's medium as well.
@export var apply_presets := true
## On during [signal edit_finished] while a field is dragged or typed to: each change is an edit, and together they are
## one to whoever undoes them, as [constant UndoRedo.MERGE_ENDS] has it.
var merges := false

var _points := Points.new()
var _axis := ValueAxis.new()
var _strips: Array[ValueStrip] = []
var _graph := OpacityGraph.new()
var _gallery := PresetGallery.new()
var _presets := Button.new()
var _middle := SpinBox.new()
var _width := SpinBox.new()
var _hint := Label.new()
var _remove: Button
var _load: Button
var _tools: Array[BaseButton] = []
var _timer := Timer.new()
var _dialog: FileDialog
var _error: AcceptDialog
var _before: Dictionary = {}
var _writing := false


func _init() -> void:
	add_theme_constant_override(&"separation", 4)
	_build_toolbar()
	for strip: ValueStrip in [WindowStrip.new(), _graph, ColorStrip.new()]:
		strip.axis = _axis
		strip.points = _points
		strip.edit_started.connect(_begin)
		strip.edited.connect(_write)
		strip.edit_finished.connect(_end)
		strip.hinted.connect(_show_hint)
		_strips.append(strip)
		add_child(strip)
	_strips[0].tooltip_text = "The window: drag to shift all values, drag an end to widen or narrow it."
	_graph.tooltip_text = "Double-click adds a knot, a right click removes one or changes a segment's ease.\n" \
			+ "The wheel zooms, the middle button pans."
	_strips[2].tooltip_text = "A click opens a stop's colour, a drag moves it, a double-click adds one,\n" \
			+ "a right click removes it."
	_timer.one_shot = true
	_timer.wait_time = HISTOGRAM_DELAY
	_timer.timeout.connect(_update_histogram)
	add_child(_timer)
	_axis.view_changed.connect(_on_view_changed)
	_refresh()


## Edits another transfer function; null clears the editor.
func set_transfer_function(value: LumivoxTransferFunction) -> void:
	if value == transfer_function:
		return
	for strip in _strips:
		strip.end_edit()
		strip.drop()
	if transfer_function != null:
		transfer_function.changed.disconnect(_on_changed)
	transfer_function = value
	if transfer_function != null:
		transfer_function.changed.connect(_on_changed)
	_graph.selected = -1
	_refresh()
	_show_points()


## Shows the histogram of another scan; null shows none.
func set_volume(value: LumivoxVolume) -> void:
	if value == volume:
		return
	volume = value
	_gallery.set_volume(volume)
	_axis.unit = volume.get_unit() if volume != null and not volume.is_empty() else ""
	_middle.suffix = _axis.unit
	_width.suffix = _axis.unit
	_refresh()
	_show_points()
	_update_histogram()


## Gives [param target] the points that [signal edit_finished] told.
func restore(target: LumivoxTransferFunction, state: Dictionary) -> void:
	Points.restore(target, state)


## Takes over the points of [param source] as one edit.
func take(source: LumivoxTransferFunction) -> void:
	if source == null or transfer_function == null:
		return
	_begin()
	_points.read(source)
	_write()
	_end()
	_show_points()


func _build_toolbar() -> void:
	var bar := HFlowContainer.new()
	bar.add_theme_constant_override(&"h_separation", 6)
	add_child(bar)
	_presets.text = "Presets"
	_presets.tooltip_text = "Looks that suit a kind of scan at once."
	_presets.pressed.connect(_open_gallery, CONNECT_DEFERRED)
	_presets.add_child(_gallery)
	_gallery.chosen.connect(_on_preset_chosen)
	bar.add_child(_presets)
	bar.add_child(_labelled("Level", _middle, "The middle of the window."))
	bar.add_child(_labelled("Width", _width, "From the first to the last point."))
	for box: SpinBox in [_middle, _width]:
		box.allow_greater = true
		box.allow_lesser = true
		box.step = 0.0001
		box.custom_arrow_step = 1.0
		box.get_line_edit().expand_to_text_length = true
		box.value_changed.connect(_on_window_typed)
	_width.allow_lesser = false
	_width.min_value = 0.001
	_hint.size_flags_horizontal = Control.SIZE_EXPAND_FILL
	_hint.horizontal_alignment = HORIZONTAL_ALIGNMENT_RIGHT
	_hint.text_overrun_behavior = TextServer.OVERRUN_TRIM_ELLIPSIS
	_hint.custom_minimum_size.x = 130.0
	_hint.modulate.a = 0.7
	bar.add_child(_hint)
	var emphasise := _tool(bar, "emphasise", "Show small opacities larger.", _on_emphasise)
	emphasise.toggle_mode = true
	_remove = _tool(bar, "remove", "Remove the selected knot (Delete).", _graph.remove_selected)
	_graph.knot_selected.connect(func(_knot: int) -> void: _show_selection())
	_tool(bar, "fit", "Show all values.", _axis.fit)
	_tool(bar, "focus", "Show the points.", _show_points)
	_load = _tool(bar, "load", "Load a transfer function (.json, .tf).", _open_dialog.bind(FileDialog.FILE_MODE_OPEN_FILE))
	_tool(bar, "save", "Save the transfer function.", _open_dialog.bind(FileDialog.FILE_MODE_SAVE_FILE))


func _labelled(text: String, box: SpinBox, tooltip: String) -> HBoxContainer:
	var row := HBoxContainer.new()
	var label := Label.new()
	label.text = text
	box.tooltip_text = tooltip
	label.tooltip_text = tooltip
	label.mouse_filter = Control.MOUSE_FILTER_PASS
	row.add_child(label)
	row.add_child(box)
	return row


func _tool(bar: Container, icon: String, tooltip: String, action: Callable) -> Button:
	var button := Button.new()
	button.icon = load("res://addons/lumivox/icons/tool_%s.svg" % icon) as Texture2D
	button.tooltip_text = tooltip
	button.flat = true
	button.pressed.connect(action)
	bar.add_child(button)
	_tools.append(button)
	return button


func _begin() -> void:
	_before = _points.state()
	edit_started.emit()


func _write() -> void:
	_writing = true
	_points.write(transfer_function)
	_writing = false
	_show_usable()
	_show_window()
	_redraw()


func _end() -> void:
	var after := _points.state()
	if after != _before:
		edit_finished.emit(_before, after)


func _on_changed() -> void:
	if _writing:
		return
	var before := _points.state()
	_refresh()
	# Somebody else replaced the points: an undo, say, or a script.
	if _points.state() != before:
		for strip in _strips:
			strip.drop()


## Reads the resource and shows it.
func _refresh() -> void:
	if transfer_function != null:
		_points.read(transfer_function)
	for strip in _strips:
		strip.transfer_function = transfer_function
	_show_usable()
	if transfer_function != null:
		var extent := _points.value_range()
		if volume != null and not volume.is_empty():
			extent = volume.get_value_range() if _points.is_empty() else _wider(extent, volume.get_value_range())
		elif _points.is_empty() or extent.x == extent.y:
			extent = _wider(extent, CT_VALUES)
		_axis.set_full(extent.x, extent.y)
	_show_window()
	_redraw()


## What can be done to the function: one without points can be given some.
func _show_usable() -> void:
	var usable := transfer_function != null and not _points.is_empty()
	_middle.editable = usable
	_width.editable = usable
	for button in _tools:
		button.disabled = not usable
	_presets.disabled = transfer_function == null
	_load.disabled = transfer_function == null
	_show_selection()


func _wider(a: Vector2, b: Vector2) -> Vector2:
	return Vector2(minf(a.x, b.x), maxf(a.y, b.y))


func _redraw() -> void:
	for strip in _strips:
		strip.queue_redraw()


func _show_window() -> void:
	if _points.is_empty():
		return
	var shown := _points.value_range()
	_middle.set_value_no_signal(snappedf((shown.x + shown.y) / 2.0, 0.01))
	_width.set_value_no_signal(snappedf(shown.y - shown.x, 0.01))


func _show_selection() -> void:
	_remove.disabled = _graph.selected < 0 or _points.knots.size() <= 1 or transfer_function == null


func _show_hint(text: String) -> void:
	_hint.text = text


func _on_window_typed(_value: float) -> void:
	var middle := _middle.value
	var width := _width.value
	_begin()
	_points.set_window(middle, width)
	_write()
	merges = true
	_end()
	merges = false


func _on_view_changed() -> void:
	_redraw()
	if is_inside_tree():
		_timer.start()


func _update_histogram() -> void:
	if volume == null or volume.is_empty():
		_graph.histogram = PackedFloat32Array()
		return
	_graph.histogram_range = _axis.view
	_graph.histogram = _smooth(volume.get_histogram(HISTOGRAM_BINS, _axis.view))


## Scans store whole numbers: bins hold two of them here and three there, which would look like a comb.
func _smooth(counts: PackedFloat32Array) -> PackedFloat32Array:
	var smooth := counts.duplicate()
	for i in range(1, counts.size() - 1):
		smooth[i] = (counts[i - 1] + 2.0 * counts[i] + counts[i + 1]) / 4.0
	return smooth


func _on_emphasise() -> void:
	_graph.emphasis = EMPHASIS if _graph.emphasis == 1.0 else 1.0


func _show_points() -> void:
	var shown := _points.value_range()
	if _points.is_empty() or shown.x == shown.y:
		_axis.fit()
		return
	var border := (shown.y - shown.x) * 0.08
	_axis.show_range(Vector2(shown.x - border, shown.y + border))


func _open_gallery() -> void:
	_gallery.open_at(Rect2(_presets.get_screen_position(), _presets.size))


func _on_preset_chosen(preset: String) -> void:
	preset_chosen.emit(preset)
	if apply_presets:
		take(LumivoxTransferFunction.preset(preset, volume))


func _open_dialog(mode: FileDialog.FileMode) -> void:
	if _dialog == null:
		_dialog = FileDialog.new()
		_dialog.access = FileDialog.ACCESS_FILESYSTEM
		_dialog.use_native_dialog = true
		_dialog.file_selected.connect(_on_file_selected)
		add_child(_dialog)
	_dialog.file_mode = mode
	var saves := mode == FileDialog.FILE_MODE_SAVE_FILE
	_dialog.filters = ["*.json;Transfer function"] if saves else ["*.json,*.tf;Transfer functions"]
	_dialog.popup_centered_clamped(Vector2i(Vector2(760.0, 520.0) * maxf(get_theme_default_base_scale(), 1.0)), 0.9)


func _on_file_selected(path: String) -> void:
	if _dialog.file_mode == FileDialog.FILE_MODE_SAVE_FILE:
		var problem := transfer_function.save_file(path)
		if problem != "":
			_show_error(problem)
		return
	var loaded := LumivoxTransferFunction.load_file(path)
	if loaded == null:
		_show_error("%s is not a transfer function that Lumivox reads." % path.get_file())
	else:
		take(loaded)


func _show_error(text: String) -> void:
	if _error == null:
		_error = AcceptDialog.new()
		_error.title = "Transfer function"
		_error.dialog_autowrap = true
		add_child(_error)
	_error.dialog_text = text
	_error.popup_centered(Vector2i(Vector2(420.0, 120.0) * maxf(get_theme_default_base_scale(), 1.0)))
