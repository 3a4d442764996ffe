@tool
extends EditorInspectorPlugin
## Adds to the inspector what a scan is, ways to get one, a way from one slice of a series to the whole, room for long
## names, and the undoing of presets.

## Emitted when a volume without a scan is to be given one.
signal import_requested(node: LumivoxVolume3D)

const DicomImporter := preload("dicom_import_plugin.gd")
const PresetProperty := preload("preset_property.gd")
const PhantomTask := preload("phantom_task.gd")
const LabelTask := preload("label_task.gd")
const PREVIEW_HEIGHT := 150.0
## Pixels of a property in an inspector that nobody widened.
const DEFAULT_WIDTH := 200.0
## Pixels beside a property's name: margins, and the arrow that reverts it.
const NAME_MARGIN := 34.0
## Largest part of a property that its name takes.
const NAME_RATIO := 0.7

var _undo: EditorUndoRedoManager
## On while the engine is asked for its own editor of a property, which asks all plugins.
var _is_asking := false


func _init(undo: EditorUndoRedoManager = null) -> void:
	_undo = undo


func _can_handle(object: Object) -> bool:
	return object is LumivoxVolume or object is LumivoxVolume3D or object is LumivoxEffect or _is_several(object)


func _parse_begin(object: Object) -> void:
	var node := object as LumivoxVolume3D
	var volume := node.volume if node != null else object as LumivoxVolume
	if node != null and (volume == null or volume.is_empty() and not volume.has_meta(DicomImporter.SERIES_META)):
		_add_start(node)
	elif volume == null:
		return
	elif volume.has_meta(DicomImporter.SERIES_META):
		_add_series_link(volume, node)
	elif node == null and not volume.is_empty():
		_add_preview(volume)


func _parse_property(
		object: Object, type: Variant.Type, name: String, hint_type: PropertyHint, hint_string: String,
		usage: int, wide: bool) -> bool:
	if _is_asking:
		return false
	if name == "preset" and (object is LumivoxVolume3D or _is_several(object)):
		_add_presets(name, object as LumivoxVolume3D)
		return true
	if (object is LumivoxVolume3D or object is LumivoxEffect) and _is_own(object, name):
		var added := _add_with_room(object, type, name, hint_type, hint_string, usage, wide)
		var node := object as LumivoxVolume3D
		if name == "labels" and node.labels == null and node.volume != null and not node.volume.is_empty():
			_add_label_finder(node)
		return added
	return false


## The gallery of presets, for one volume or for all that are selected.
func _add_presets(name: String, node: LumivoxVolume3D) -> void:
	var volumes := selected_volumes()
	if node != null:
		volumes = [node]
	var editor := PresetProperty.new(volumes)
	editor.chosen_for_all.connect(func(preset: String) -> void:
		apply_preset(_undo, volumes, preset)
		editor.update_property())
	add_property_editor(name, editor)


static func _is_own(object: Object, name: String) -> bool:
	return ClassDB.class_get_property_list(object.get_class(), true).any(func(property: Dictionary) -> bool:
		return property.name == name)


## The engine's own editor of a property, with as much room as its name needs.
func _add_with_room(
		object: Object, type: Variant.Type, name: String, hint_type: PropertyHint, hint_string: String,
		usage: int, wide: bool) -> bool:
	_is_asking = true
	var editor := EditorInspector.instantiate_property_editor(object, type, name, hint_type, hint_string, usage, wide)
	_is_asking = false
	if editor == null:
		return false
	var theme := EditorInterface.get_editor_theme()
	var text := name.capitalize()
	var needed := theme.default_font.get_string_size(
			text, HORIZONTAL_ALIGNMENT_LEFT, -1.0, theme.default_font_size).x / EditorInterface.get_editor_scale()
	editor.name_split_ratio = clampf((needed + NAME_MARGIN) / DEFAULT_WIDTH, 0.5, NAME_RATIO)
	add_property_editor(name, editor)
	return true


## Whether the inspector shows several nodes at once, all of them volumes.
func _is_several(object: Object) -> bool:
	return object.get_class() == "MultiNodeEdit" and not selected_volumes().is_empty() \
			and selected_volumes().size() == EditorInterface.get_selection().get_selected_nodes().size()


## The volumes among the selected nodes.
static func selected_volumes() -> Array[LumivoxVolume3D]:
	var volumes: Array[LumivoxVolume3D] = []
	for node in EditorInterface.get_selection().get_selected_nodes():
		if node is LumivoxVolume3D:
			volumes.append(node as LumivoxVolume3D)
	return volumes


## Gives volumes the look of a preset, as one step of undo. Those that it does not suit stay as they are.
static func apply_preset(undo: EditorUndoRedoManager, nodes: Array[LumivoxVolume3D], preset: String) -> void:
	if nodes.is_empty():
		return
	var name := "Apply Preset" if nodes.size() == 1 else "Apply Preset to %d Volumes" % nodes.size()
	undo.create_action(name, UndoRedo.MERGE_DISABLE, nodes[0])
	for node in nodes:
		_record(undo, node, preset)
	undo.commit_action()


## What a preset may set: everything that a volume's node stores.
static func stored(node: LumivoxVolume3D) -> Dictionary[StringName, Variant]:
	var values: Dictionary[StringName, Variant] = {}
	for property in ClassDB.class_get_property_list(&"LumivoxVolume3D", true):
		if (property.usage as int) & PROPERTY_USAGE_STORAGE != 0:
			var key := StringName(property.name as String)
			values[key] = node.get(key)
	return values


## Adds to the inspector's action of choosing a preset all that the preset sets, and what was there before: undone, the
## node is as it was; done again, it has the very transfer function that later actions edit.
static func record_preset(undo: Object, object: Object, property: String, value: Variant) -> void:
	var node := object as LumivoxVolume3D
	if node == null or property != "preset":
		return
	_record(undo, node, value as String)


## The values that a preset changes, and what was there before.
static func _record(undo: Object, node: LumivoxVolume3D, preset: String) -> void:
	var before := stored(node)
	var after := before.duplicate()
	if preset == "":
		after[&"chosen_preset"] = ""
	elif node.apply_preset(preset):
		after = stored(node)
		for key in before:
			node.set(key, before[key])
	for key in before:
		undo.call(&"add_undo_property", node, key, before[key])
		if after[key] != before[key]:
			undo.call(&"add_do_property", node, key, after[key])


## Buttons for a node that has nothing to show yet.
func _add_start(node: LumivoxVolume3D) -> void:
	var row := HBoxContainer.new()
	var scan := Button.new()
	scan.text = "Import a Scan..."
	scan.tooltip_text = "A folder of DICOM files, an archive, or a file of another format."
	scan.pressed.connect(func() -> void: import_requested.emit(node))
	var phantom := Button.new()
	phantom.text = "Try a Phantom"
	phantom.tooltip_text = "Computes the CT of a head and saves it as %s." % PhantomTask.PATH
	phantom.pressed.connect(_use_phantom.bind(node, phantom))
	for button: Button in [scan, phantom]:
		button.size_flags_horizontal = Control.SIZE_EXPAND_FILL
		button.clip_text = true
		row.add_child(button)
	add_custom_control(row)


func _use_phantom(node: LumivoxVolume3D, button: Button) -> void:
	var known := load(PhantomTask.PATH) as LumivoxVolume if ResourceLoader.exists(PhantomTask.PATH) else null
	if known != null:
		_give(known, node)
		return
	button.disabled = true
	button.text = "Computing..."
	var task := PhantomTask.new()
	task.done.connect(_give.bind(node))
	EditorInterface.get_base_control().add_child(task)


func _give(volume: LumivoxVolume, node: LumivoxVolume3D) -> void:
	if is_instance_valid(node) and volume != null:
		give_volume(_undo, node, volume)


## Sets a node's scan, as one step of undo.
static func give_volume(undo: EditorUndoRedoManager, node: LumivoxVolume3D, volume: LumivoxVolume) -> void:
	_give_resource(undo, node, "Set Volume", &"volume", volume)


static func _give_resource(undo: EditorUndoRedoManager, node: LumivoxVolume3D, action: String, property: StringName,
		value: Resource) -> void:
	undo.create_action(action, UndoRedo.MERGE_DISABLE, node)
	undo.add_do_property(node, property, value)
	undo.add_undo_property(node, property, node.get(property))
	undo.add_do_method(node, &"notify_property_list_changed")
	undo.add_undo_method(node, &"notify_property_list_changed")
	undo.commit_action()


## A button that finds the parts of a scan, and cancels that when it is pressed again.
func _add_label_finder(node: LumivoxVolume3D) -> void:
	var button := Button.new()
	button.text = "Find Parts"
	button.clip_text = true
	button.tooltip_text = "Finds lungs, airways, the table and what else a scan shows by itself. Saved as %s." \
			% LabelTask.path_for(node.volume)
	button.pressed.connect(_find_labels.bind(node, button))
	add_custom_control(button)


func _find_labels(node: LumivoxVolume3D, button: Button) -> void:
	if button.has_meta(&"task"):
		# The inspector may have been drawn anew since.
		var running: Variant = button.get_meta(&"task")
		if is_instance_valid(running):
			(running as LabelTask).cancel()
		return
	var task := LabelTask.new()
	var show := func(text: String) -> void:
		if is_instance_valid(button):
			button.text = text
	task.progressed.connect(func(part: float) -> void: show.call("Finding Parts: %d %% (Cancel)" % int(100.0 * part)))
	task.done.connect(func(labels: LumivoxLabels) -> void:
		show.call("Find Parts")
		if is_instance_valid(button):
			button.remove_meta(&"task")
		if labels != null and is_instance_valid(node):
			_give_resource(_undo, node, "Set Labels", &"labels", labels))
	EditorInterface.get_base_control().add_child(task)
	if task.start(node.volume):
		button.set_meta(&"task", task)
	else:
		task.queue_free()


func _add_series_link(volume: LumivoxVolume, node: LumivoxVolume3D) -> void:
	var path: String = volume.get_meta(DicomImporter.SERIES_META)
	var label := Label.new()
	label.text = "This file is one slice. Its scan was imported with %s." % path.get_file()
	label.autowrap_mode = TextServer.AUTOWRAP_WORD_SMART
	add_custom_control(label)
	var button := Button.new()
	button.text = "Use the Whole Scan" if node != null else "Show the Whole Scan"
	button.pressed.connect(_use_series.bind(path, node))
	add_custom_control(button)


func _use_series(path: String, node: LumivoxVolume3D) -> void:
	var whole := load(path) as LumivoxVolume
	if whole == null:
		push_error("Lumivox: %s could not be loaded; reimport it." % path)
	elif node == null:
		EditorInterface.edit_resource(whole)
	else:
		give_volume(_undo, node, whole)


func _add_preview(volume: LumivoxVolume) -> void:
	var scale := EditorInterface.get_editor_scale()
	var row := HBoxContainer.new()
	row.custom_minimum_size.y = PREVIEW_HEIGHT * scale
	var dims := volume.get_dimensions()
	var extent := volume.get_value_range()
	# Soft tissue for CT; the values that occur for everything else.
	var window := Vector2(-160.0, 240.0) if volume.get_unit() == "HU" else extent
	for axis: int in [2, 1, 0]:
		var slice := volume.get_slice(axis, dims[axis] >> 1, window)
		if slice == null:
			continue
		var picture := TextureRect.new()
		picture.texture = ImageTexture.create_from_image(slice)
		picture.expand_mode = TextureRect.EXPAND_IGNORE_SIZE
		picture.stretch_mode = TextureRect.STRETCH_KEEP_ASPECT_CENTERED
		picture.size_flags_horizontal = Control.SIZE_EXPAND_FILL
		row.add_child(picture)
	add_custom_control(row)
	var spacing := volume.get_spacing_mm()
	var label := Label.new()
	label.autowrap_mode = TextServer.AUTOWRAP_WORD_SMART
	label.text = "%d × %d × %d voxels of %s × %s × %s mm, %s to %s %s" % [
		dims.x, dims.y, dims.z, String.num(spacing.x, 3), String.num(spacing.y, 3), String.num(spacing.z, 3),
		String.num(extent.x, 3), String.num(extent.y, 3), volume.get_unit()]
	for note: String in volume.get_report().get("notes", PackedStringArray()):
		label.text += "\n• " + note
	add_custom_control(label)
