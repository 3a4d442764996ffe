@tool
extends PanelContainer
## The bottom panel's transfer-function editor: follows the selected volume, with undo.

const VolumeInspector := preload("volume_inspector.gd")

var _undo: EditorUndoRedoManager
var _node: LumivoxVolume3D
## What a node without a function of its own is shown with. The first edit makes it the node's own.
var _suited: LumivoxTransferFunction
## The scan that it suits.
var _suited_to: LumivoxVolume
var _editor := LumivoxTransferFunctionEditor.new()
var _notice := Label.new()
var _message := Label.new()


func _init(undo: EditorUndoRedoManager = null) -> void:
	_undo = undo
	name = "TransferFunction"
	add_theme_stylebox_override(&"panel", StyleBoxEmpty.new())
	_editor.apply_presets = false
	_editor.size_flags_vertical = Control.SIZE_EXPAND_FILL
	_editor.edit_finished.connect(_on_edit_finished)
	_editor.preset_chosen.connect(_on_preset_chosen)
	var column := VBoxContainer.new()
	_notice.text_overrun_behavior = TextServer.OVERRUN_TRIM_ELLIPSIS
	_notice.mouse_filter = Control.MOUSE_FILTER_PASS
	column.add_child(_notice)
	column.add_child(_editor)
	add_child(column)
	_message.horizontal_alignment = HORIZONTAL_ALIGNMENT_CENTER
	_message.autowrap_mode = TextServer.AUTOWRAP_WORD_SMART
	_message.size_flags_vertical = Control.SIZE_SHRINK_CENTER
	add_child(_message)
	_show_state()


func _ready() -> void:
	custom_minimum_size.y = 290.0 * EditorInterface.get_editor_scale()


func _process(_delta: float) -> void:
	# Volume and transfer function of a node may be exchanged in the inspector at any time.
	if _node == null and _editor.transfer_function == null:
		return
	if _node != null and not is_instance_valid(_node):
		_node = null
		_editor.transfer_function = null
		_show_state()
	elif _node != null and (_editor.volume != _node.volume or _editor.transfer_function != _function_in_force()):
		_take_node()


## Edits what a node shows, whatever becomes of it.
func follow_node(node: LumivoxVolume3D) -> void:
	if node != _node:
		# An edit that is under way ends as one of the node before.
		_editor.transfer_function = null
		_suited_to = null
	_node = node
	_take_node()


## Edits a resource on its own; one of the node that is followed keeps that node's histogram.
func follow_resource(resource: LumivoxTransferFunction) -> void:
	if is_instance_valid(_node) and _node.transfer_function == resource:
		return
	_editor.transfer_function = resource
	_node = null
	_editor.volume = null
	_show_state()


func _take_node() -> void:
	var function := _function_in_force()
	_editor.volume = _node.volume
	_editor.transfer_function = function
	_show_state()


## The function that the node is shown with: its own, or that of the preset that suits its scan; null without a scan.
func _function_in_force() -> LumivoxTransferFunction:
	if _node.transfer_function != null:
		return _node.transfer_function
	if _node.volume == null or _node.volume.is_empty():
		return null
	if _suited_to != _node.volume:
		_suited_to = _node.volume
		if _suited != null:
			_suited.changed.disconnect(_on_suited_changed)
		_suited = LumivoxTransferFunction.preset(_suiting_preset(), _node.volume)
		_suited.changed.connect(_on_suited_changed)
	return _suited


func _suiting_preset() -> String:
	return LumivoxTransferFunctionEditor.PresetGallery.suiting(_node.volume)


## The first edit of a function that is nobody's: the picture follows at once, and the whole edit is one step of undo.
func _on_suited_changed() -> void:
	if is_instance_valid(_node) and _editor.transfer_function == _suited and _node.transfer_function == null:
		_node.transfer_function = _suited
		_show_state()


func _show_state() -> void:
	var editable := _editor.transfer_function != null
	_editor.visible = editable
	_message.visible = not editable
	_notice.visible = is_instance_valid(_node) and editable
	if not is_instance_valid(_node):
		_message.text = "Select a LumivoxVolume3D to edit its transfer function."
		return
	_message.text = "%s has no volume yet." % _node.name
	var preset := LumivoxTransferFunctionEditor.PresetGallery.title(_node.preset) if _node.preset != "" else ""
	if editable and _node.transfer_function == null:
		preset = LumivoxTransferFunctionEditor.PresetGallery.title(_suiting_preset())
		_notice.text = "%s: %s, which suits its scan, until you choose or edit" % [_node.name, preset]
	elif preset != "":
		_notice.text = "%s: begun with %s" % [_node.name, preset]
	else:
		_notice.text = "%s: no preset" % _node.name
	_notice.tooltip_text = _notice.text


func _on_edit_finished(before: Dictionary, after: Dictionary) -> void:
	var edited := _editor.transfer_function
	var mode := UndoRedo.MERGE_ENDS if _editor.merges else UndoRedo.MERGE_DISABLE
	var is_nodes := is_instance_valid(_node) and _node.transfer_function == edited
	# The first edit of what was in force without being the node's own.
	var adopts := is_nodes and edited == _suited
	_undo.create_action("Set Window" if _editor.merges else "Edit Transfer Function", mode, _context())
	if is_nodes:
		# Each time: of edits that merge, the last is done again.
		_undo.add_do_property(_node, &"transfer_function", edited)
	_undo.add_do_method(_editor, &"restore", edited, after)
	_undo.add_undo_method(_editor, &"restore", edited, before)
	if adopts:
		_undo.add_undo_property(_node, &"transfer_function", null)
		_suited.changed.disconnect(_on_suited_changed)
		_suited = null
		_suited_to = null
	_undo.commit_action(false)


## A preset sets the whole medium of all selected nodes; of a resource on its own, the points.
func _on_preset_chosen(preset: String) -> void:
	if not is_instance_valid(_node):
		_editor.take(LumivoxTransferFunction.preset(preset, _editor.volume))
		return
	VolumeInspector.apply_preset(_undo, _edited_nodes(), preset)


## The volume that is shown, and those selected with it.
func _edited_nodes() -> Array[LumivoxVolume3D]:
	var nodes := VolumeInspector.selected_volumes()
	return nodes if _node in nodes else ([_node] as Array[LumivoxVolume3D])


## Which undo history an edit belongs to: the scene's for a built-in resource, else the resource's own.
func _context() -> Object:
	var path := _editor.transfer_function.resource_path
	if is_instance_valid(_node) and (path == "" or path.contains("::")):
		return _node
	return _editor.transfer_function
