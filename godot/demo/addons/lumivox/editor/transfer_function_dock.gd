@tool
extends PanelContainer
## The bottom panel's transfer-function editor: follows the selected volume, with undo.

const VolumeInspector := preload("volume_inspector.gd")

var _undo: EditorUndoRedoManager
var _node: LumivoxVolume3D
var _editor := LumivoxTransferFunctionEditor.new()
var _empty := VBoxContainer.new()
var _message := Label.new()
var _create := Button.new()


func _init(undo: EditorUndoRedoManager = null) -> void:
	_undo = undo
	name = "TransferFunction"
	add_theme_stylebox_override(&"panel", StyleBoxEmpty.new())
	_editor.apply_presets = false
	_editor.edit_finished.connect(_on_edit_finished)
	_editor.preset_chosen.connect(_on_preset_chosen)
	add_child(_editor)
	_message.horizontal_alignment = HORIZONTAL_ALIGNMENT_CENTER
	_create.text = "Create from Preset"
	_create.size_flags_horizontal = Control.SIZE_SHRINK_CENTER
	_create.pressed.connect(_on_create)
	_empty.alignment = BoxContainer.ALIGNMENT_CENTER
	_empty.add_child(_message)
	_empty.add_child(_create)
	add_child(_empty)
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
	elif _node != null and (_editor.volume != _node.volume or _editor.transfer_function != _node.transfer_function):
		_take_node()


## Edits what a node shows, whatever becomes of it.
func follow_node(node: LumivoxVolume3D) -> void:
	# An edit that is under way ends as one of the node before.
	_editor.transfer_function = node.transfer_function
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
	_editor.volume = _node.volume
	_editor.transfer_function = _node.transfer_function
	_show_state()


func _show_state() -> void:
	var editable := _editor.transfer_function != null
	_editor.visible = editable
	_empty.visible = not editable
	var shows_scan := is_instance_valid(_node) and _node.volume != null and not _node.volume.is_empty()
	_create.visible = shows_scan
	if not is_instance_valid(_node):
		_message.text = "Select a LumivoxVolume3D to edit its transfer function."
	elif not shows_scan:
		_message.text = "%s has no volume yet." % _node.name
	else:
		_message.text = "%s has no transfer function of its own: it is shown with the preset for its kind of scan." \
				% _node.name


func _on_create() -> void:
	_undo.create_action("Create Transfer Function", UndoRedo.MERGE_DISABLE, _node)
	for node in _edited_nodes():
		if node.transfer_function != null or node.volume == null or node.volume.is_empty():
			continue
		var preset := LumivoxTransferFunctionEditor.PresetGallery.suiting(node.volume)
		if node.preset in LumivoxVolume3D.preset_names():
			preset = node.preset
		_undo.add_do_property(node, &"transfer_function", LumivoxTransferFunction.preset(preset, node.volume))
		_undo.add_undo_property(node, &"transfer_function", null)
	_undo.commit_action()


func _on_edit_finished(before: Dictionary, after: Dictionary) -> void:
	var edited := _editor.transfer_function
	var mode := UndoRedo.MERGE_ENDS if _editor.merges else UndoRedo.MERGE_DISABLE
	_undo.create_action("Set Window" if _editor.merges else "Edit Transfer Function", mode, _context())
	_undo.add_do_method(_editor, &"restore", edited, after)
	_undo.add_undo_method(_editor, &"restore", edited, before)
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
