extends Node
## Uses the transfer-function editor where there is little to edit, and where somebody else edits at the same time.

var _editor := LumivoxTransferFunctionEditor.new()
var _edits: Array = []
## Steps as an owner keeps them.
var _undo := UndoRedo.new()
var _told := {}


func _ready() -> void:
	_editor.size = Vector2(900.0, 400.0)
	add_child(_editor)
	_editor.edit_finished.connect(_on_edit_finished)
	await _begin_empty()
	await _type_window()
	_replace_while_dragging()
	print("TELL function %s" % JSON.stringify(_told))
	_undo.free()
	get_tree().quit()


func _on_edit_finished(before: Dictionary, after: Dictionary) -> void:
	_edits.append([before, after])
	_undo.create_action("edit", UndoRedo.MERGE_ENDS if _editor.merges else UndoRedo.MERGE_DISABLE)
	_undo.add_do_method(_editor.restore.bind(_editor.transfer_function, after))
	_undo.add_undo_method(_editor.restore.bind(_editor.transfer_function, before))
	_undo.commit_action(false)


func _check(what: String, ok: bool) -> void:
	_told[what] = ok


func _graph() -> Control:
	return _editor.get("_graph")


func _colors() -> Control:
	return (_editor.get("_strips") as Array)[2]


func _button(at: Vector2, pressed: bool, double := false) -> void:
	var event := InputEventMouseButton.new()
	event.position = at
	event.global_position = at
	event.button_index = MOUSE_BUTTON_LEFT
	event.pressed = pressed
	event.double_click = double
	event.button_mask = MOUSE_BUTTON_MASK_LEFT if pressed else 0
	get_viewport().push_input(event, true)


func _move(at: Vector2) -> void:
	var event := InputEventMouseMotion.new()
	event.position = at
	event.global_position = at
	event.relative = Vector2(5.0, 0.0)
	event.button_mask = MOUSE_BUTTON_MASK_LEFT
	get_viewport().push_input(event, true)


func _is_enabled(names: Array[String]) -> bool:
	return names.all(func(name: String) -> bool: return not (_editor.get(name) as BaseButton).disabled)


func _begin_empty() -> void:
	var function := LumivoxTransferFunction.new()
	_editor.transfer_function = function
	await get_tree().process_frame
	await get_tree().process_frame
	var axis := _editor.get("_axis") as RefCounted
	_check("an empty function offers presets and files", _is_enabled(["_presets", "_load"]))
	_check("over the values of a CT", axis.get("view") == Vector2(-1024.0, 3071.0))
	var graph := _graph()
	var words := OS.get_cmdline_user_args()
	get_viewport().get_texture().get_image().save_png(words[words.find("--out") + 1].path_join("empty.png"))
	var at := graph.global_position + graph.size * Vector2(0.5, 0.4)
	_button(at, true, true)
	_move(at + Vector2(40.0, 0.0))
	_button(at + Vector2(40.0, 0.0), false)
	var knots := function.opacity_knots
	_check("a double click adds the first knot, to be dragged on", knots.size() == 1 and absf(knots[0].x - 1200.0) < 150.0)
	_check("as one edit", _edits.size() == 1 and (_edits[0][0] as Dictionary).opacity_knots == PackedVector2Array())
	_check("with tools for it", (_editor.get("_middle") as SpinBox).editable and function.colors == PackedColorArray([Color.WHITE]))
	_editor.restore(function, _edits[0][0] as Dictionary)
	_check("which can be undone", function.opacity_knots.is_empty() and _is_enabled(["_presets"]))
	_editor.volume = LumivoxVolume.phantom("head", 32)
	_check("a volume has its own values", axis.get("full") == _editor.volume.get_value_range())
	_editor.emit_signal(&"preset_chosen", "ct-bone")
	_editor.take(LumivoxTransferFunction.preset("ct-bone"))
	_check("a preset fills it", function.opacity_knots.size() > 1)
	function.set_points(PackedVector2Array([Vector2(0, 0), Vector2(500, 1)]), [0, 0], [], [])
	_check("one without colours is white", (_editor.get("_points") as RefCounted).get("colors") == PackedColorArray([Color.WHITE]))
	_edits.clear()


func _type_window() -> void:
	var function := LumivoxTransferFunction.preset("ct-muscle")
	_editor.transfer_function = function
	var middle := _editor.get("_middle") as SpinBox
	var width := _editor.get("_width") as SpinBox
	var level := middle.value
	_undo.clear_history()
	for i in 20:
		middle.value += 5.0
		await get_tree().process_frame
	_check("the window follows each change", absf(function.shift - 100.0) < 0.1)
	_check("a dragged field is one step to undo", _undo.get_history_count() == 1 and _edits.size() == 20)
	_undo.undo()
	_check("from the last to the first", function.shift == 0.0)
	_undo.redo()
	_check("and back", absf(function.shift - 100.0) < 0.1)
	var points: Dictionary = (_editor.get("_points") as RefCounted).call("state")
	var strip := _colors()
	strip.call("_open_picker", 1)
	var popup := strip.get("_popup") as PopupPanel
	var shown := popup.visible
	_editor.restore(function, _edits[0][0] as Dictionary)
	(strip.get("_picker") as ColorPicker).color_changed.emit(Color.GREEN)
	_check("a picker closes with the stop that it shows", shown and not popup.visible and not function.colors.has(Color.GREEN))
	_editor.restore(function, points)
	middle.value = level
	width.value = 1.0
	var scale: float = (_editor.get("_points") as RefCounted).get("window_scale")
	_check("the narrowest window is the resource's", scale == function.window_scale and function.window_scale == 0.01)
	_check("and is shown", absf(width.value - 8.4) < 0.011)
	function.window_scale = 1.0
	var graph := _graph()
	var at := graph.get_global_transform() * (graph.call("_position_of", 1) as Vector2)
	_button(at, true)
	_move(at + Vector2(5.0, 0.0))
	var edits := _edits.size()
	_editor.transfer_function = null
	_button(at, false)
	_check("a drag ends with its function", _edits.size() == edits + 1)
	_edits.clear()


func _replace_while_dragging() -> void:
	var function := LumivoxTransferFunction.preset("ct-muscle")
	_editor.transfer_function = function
	var graph := _graph()
	var last := function.opacity_knots.size() - 1
	var at := graph.get_global_transform() * (graph.call("_position_of", last) as Vector2)
	_button(at, true)
	_move(at + Vector2(-10.0, 0.0))
	var others := PackedVector2Array([Vector2(0, 0), Vector2(500, 1)])
	function.opacity_knots = others
	_move(at + Vector2(-20.0, 0.0))
	_button(at, false)
	_check("knots that a script replaced stay", function.opacity_knots == others)
	var strip := _colors()
	var stop: float = function.color_values[-1]
	at = strip.get_global_transform() * Vector2(strip.call("x_of", stop) as float, strip.size.y * 0.7)
	_button(at, true)
	_move(at + Vector2(-10.0, 0.0))
	function.colors = PackedColorArray()
	strip.queue_redraw()
	_move(at + Vector2(-20.0, 0.0))
	_button(at, false)
	_check("so do colours", function.colors.is_empty())
	_check("neither is an edit", _edits.is_empty())
